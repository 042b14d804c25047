#include "gvx/render/tile/stretch_batch.h"

#include <algorithm>

#include "gvx/render/vectors/stretch_batch_types.h"

namespace gvx::render {

void StretchBatch::put_in_order() {
  // Two halves of the rows, each with its own counts: of one, each would wait for the row before.
  std::uint16_t first[256][2] = {};
  const std::uint32_t half = count / 2;
  unsigned longest = 0;
  const auto count_row = [&](std::uint32_t i, int which) {
    ++first[length[i]][which];
    longest = std::max<unsigned>(longest, length[i]);
  };
  for (std::uint32_t i = 0; i < half; ++i) {
    count_row(i, 0);
    count_row(half + i, 1);
  }
  if (count % 2 != 0) count_row(count - 1, 1);
  std::uint16_t sum = 0;
  for (unsigned steps = 0; steps <= longest; ++steps) {
    for (std::uint16_t& begin : first[steps]) {
      const std::uint16_t here = begin;
      begin = sum;
      sum = static_cast<std::uint16_t>(sum + here);
    }
  }
  const auto put_row = [&](std::uint32_t i, int which) {
    order[first[length[i]][which]++] = static_cast<std::int32_t>(i);
  };
  for (std::uint32_t i = 0; i < half; ++i) {
    put_row(i, 0);
    put_row(half + i, 1);
  }
  if (count % 2 != 0) put_row(count - 1, 1);
}

void composite_batch(const FrameView& frame, StretchBatch& batch) {
  switch (frame.format.type) {
    case VoxelType::u8:
      return composite_batch_u8(frame, batch);
    case VoxelType::u16:
      return composite_batch_u16(frame, batch);
    case VoxelType::f32:
      return composite_batch_f32(frame, batch);
  }
}

void composite_post_batch(const FrameView& frame, StretchBatch& batch) {
  switch (frame.format.type) {
    case VoxelType::u8:
      return post_batch_u8(frame, batch);
    case VoxelType::u16:
      return post_batch_u16(frame, batch);
    case VoxelType::f32:
      return post_batch_f32(frame, batch);
  }
}

}  // namespace gvx::render
