/// \file
/// StretchBatch: the stretches of many rays through one brick, side by side for a processor's vectors; and
/// composite_batch, which composites them as composite.h does one. The vectors are the widest that the
/// processor has (Google Highway, chosen at run time).
#pragma once

#include <cstddef>
#include <cstdint>

#include "gvx/render/frame.h"

namespace gvx::render {

struct StretchBatch {
  /// As many rays as a tile of a film has.
  static constexpr std::uint32_t kMost = 256;

  /// A brick of the tree's format, and the rays' way through it: in voxels from its low corner, from the
  /// centre of the first step.
  struct Path {
    const std::byte* brick = nullptr;
    bool deviates = false;
    float gradient_scale = 1;
    alignas(64) float first[3][kMost];
    alignas(64) float per_step[3][kMost];
  };

  std::uint32_t m = 16;  ///< the bricks' edge, 8, 16 or 32
  int level = 0;         ///< of the steps
  float units = 1;       ///< unit distances of the extinctions a step
  bool blended = false;  ///< the coarse brick is seen too
  Path fine, coarse;

  /// Of the fine brick's cells those that can be seen (visible_cells.h); for batches of one brick.
  std::uint64_t cells = ~std::uint64_t(0);

  std::uint32_t count = 0;  ///< rays
  alignas(64) std::int32_t steps[kMost];
  /// The coarse brick's share at the centre of the first step and its growth a step; it is held from 0 to 1.
  alignas(64) float blend[kMost];
  alignas(64) float blend_per_step[kMost];
  alignas(64) float to_eye[3][kMost];
  /// Where in the world the centre of the first step is, and the way of a step.
  alignas(64) float place[3][kMost];
  alignas(64) float place_per_step[3][kMost];

  /// What the rays have gathered (RayState).
  alignas(64) float color[3][kMost];
  alignas(64) float opacity[kMost];
  alignas(64) std::int32_t samples[kMost];

  /// Where a brick of bytes is put, if that pays: each texel beside the one behind it along y.
  bool paired = false;
  alignas(64) std::uint16_t row_pairs[plane_texels(32)];
};

/// Are there vectors for this way to look? Scalars of one channel, composited, without opacity by gradient.
bool composites_batches(const FrameView& frame);

/// The name of the instruction set whose vectors composite_batch uses: "AVX3", "AVX2", "SSE4", "NEON"..
const char* instruction_set();

/// Adds what is seen of every ray's stretch to what it has gathered. A ray's bits do not depend on the others
/// in the batch. Only where composites_batches(frame).
void composite_batch(const FrameView& frame, StretchBatch& batch);

/// The same by post-classification (post_classified.h), in frames that have step_colors.
void composite_post_batch(const FrameView& frame, StretchBatch& batch);

}  // namespace gvx::render
