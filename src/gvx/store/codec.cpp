#include "gvx/store/codec.h"

#include <algorithm>
#include <cstring>
#include <memory>

#include <lz4.h>
#include <zstd.h>

namespace gvx::store {
namespace {

// Level 1: higher levels gain a few per cent of size on noisy scans and cost a multiple of the time.
constexpr int kZstdLevel = 1;

void split_planes(BlockLayout layout, std::span<const std::byte> in, std::byte* out) {
  const std::size_t width = layout.element_bytes, count = layout.elements;
  for (std::size_t plane = 0; plane < width; ++plane) {
    for (std::size_t i = 0; i < count; ++i) out[plane * count + i] = in[i * width + plane];
  }
  std::copy(in.begin() + static_cast<std::ptrdiff_t>(width * count), in.end(), out + width * count);
}

void join_planes(BlockLayout layout, const std::byte* in, std::span<std::byte> out) {
  const std::size_t width = layout.element_bytes, count = layout.elements;
  for (std::size_t plane = 0; plane < width; ++plane) {
    for (std::size_t i = 0; i < count; ++i) out[i * width + plane] = in[plane * count + i];
  }
  std::copy(in + width * count, in + out.size(), out.begin() + static_cast<std::ptrdiff_t>(width * count));
}

/// Contexts are costly to make; each thread keeps its own.
ZSTD_CCtx* compression_context() {
  thread_local const std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> context(ZSTD_createCCtx(),
                                                                                  ZSTD_freeCCtx);
  return context.get();
}

ZSTD_DCtx* decompression_context() {
  thread_local const std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> context(ZSTD_createDCtx(),
                                                                                  ZSTD_freeDCtx);
  return context.get();
}

}  // namespace

void compress(Codec codec, BlockLayout layout, std::span<const std::byte> raw,
              std::vector<std::byte>& compressed) {
  if (codec == Codec::none) {
    compressed.assign(raw.begin(), raw.end());
    return;
  }
  thread_local std::vector<std::byte> planes;
  if (layout.element_bytes > 1) {
    planes.resize(raw.size());
    split_planes(layout, raw, planes.data());
    raw = planes;
  }
  // Room for the worst case is the thread's; what is handed out has its own size.
  thread_local std::vector<std::byte> room;
  std::size_t bytes = 0;
  if (codec == Codec::zstd) {
    room.resize(std::max(room.size(), ZSTD_compressBound(raw.size())));
    bytes = ZSTD_compressCCtx(compression_context(), room.data(), room.size(), raw.data(), raw.size(),
                              kZstdLevel);
    GVX_CHECK(!ZSTD_isError(bytes));
  } else {
    const int size = static_cast<int>(raw.size());
    room.resize(std::max(room.size(), static_cast<std::size_t>(LZ4_compressBound(size))));
    const int written =
        LZ4_compress_default(reinterpret_cast<const char*>(raw.data()), reinterpret_cast<char*>(room.data()),
                             size, static_cast<int>(room.size()));
    GVX_CHECK(written > 0);
    bytes = static_cast<std::size_t>(written);
  }
  compressed.assign(room.begin(), room.begin() + static_cast<std::ptrdiff_t>(bytes));
}

Status decompress(Codec codec, BlockLayout layout, std::span<const std::byte> compressed,
                  std::span<std::byte> raw) {
  const auto wrong_size = [&] {
    return Error{std::string("a block is not ") + codec_name(codec) + " of " + std::to_string(raw.size()) +
                 " bytes"};
  };
  if (codec == Codec::none) {
    if (compressed.size() != raw.size()) return wrong_size();
    std::memcpy(raw.data(), compressed.data(), raw.size());
    return {};
  }
  thread_local std::vector<std::byte> planes;
  std::byte* target = raw.data();
  if (layout.element_bytes > 1) {
    planes.resize(raw.size());
    target = planes.data();
  }
  if (codec == Codec::zstd) {
    const std::size_t bytes = ZSTD_decompressDCtx(decompression_context(), target, raw.size(),
                                                  compressed.data(), compressed.size());
    if (ZSTD_isError(bytes) || bytes != raw.size()) return wrong_size();
  } else {
    const int bytes =
        LZ4_decompress_safe(reinterpret_cast<const char*>(compressed.data()), reinterpret_cast<char*>(target),
                            static_cast<int>(compressed.size()), static_cast<int>(raw.size()));
    if (bytes < 0 || static_cast<std::size_t>(bytes) != raw.size()) return wrong_size();
  }
  if (layout.element_bytes > 1) join_planes(layout, planes.data(), raw);
  return {};
}

}  // namespace gvx::store
