/// \file
/// A 3D texture of floats with trilinear filtering and clamped edges: the GPU's texture unit on CUDA, the
/// same arithmetic in software on the CPU. Texel i has its centre at coordinate i + 0.5.
#pragma once

#include <cstdint>
#include <span>

#include "gvx/core/vec.h"
#include "gvx/exec/buffer.h"

#if defined(__CUDACC__)
#include <cuda_runtime.h>
#endif

namespace gvx::exec {

/// What kernels sample. The CPU reads texels; CUDA goes through the texture object, whose weights have 8
/// bits.
struct Texture3DView {
  const float* texels = nullptr;
  std::uint32_t size_x = 0, size_y = 0, size_z = 0;
  unsigned long long texture_object = 0;

  /// The filtered value at (x, y, z) in texels.
  GVX_HD float sample(float x, float y, float z) const {
#if defined(__CUDA_ARCH__)
    return tex3D<float>(static_cast<cudaTextureObject_t>(texture_object), x, y, z);
#else
    const Axis ax(x, size_x), ay(y, size_y), az(z, size_z);
    const auto row = [&](std::uint32_t iy, std::uint32_t iz) {
      const float* texel = texels + (std::size_t(iz) * size_y + iy) * size_x;
      return texel[ax.low] + ax.weight * (texel[ax.high] - texel[ax.low]);
    };
    const auto slice = [&](std::uint32_t iz) {
      const float low = row(ay.low, iz);
      return low + ay.weight * (row(ay.high, iz) - low);
    };
    const float low = slice(az.low);
    return low + az.weight * (slice(az.high) - low);
#endif
  }

 private:
  struct Axis {
    std::uint32_t low, high;
    float weight;
    GVX_HD Axis(float coordinate, std::uint32_t size) {
      const float last = static_cast<float>(size - 1);
      float texel = coordinate - 0.5f;
      texel = texel < 0 ? 0 : texel > last ? last : texel;
      low = static_cast<std::uint32_t>(texel);
      high = low + 1 < size ? low + 1 : low;
      weight = texel - static_cast<float>(low);
    }
  };
};

/// Owns a texture on a device; moves, never copies.
class Texture3D {
 public:
  /// `texels`: size_x * size_y * size_z values, x fastest.
  Texture3D(const Device& device, Vec3u size, std::span<const float> texels);
  Texture3D(Texture3D&& other) noexcept;
  Texture3D& operator=(Texture3D&&) = delete;
  ~Texture3D();

  Texture3DView view() const;

 private:
  Vec3u size_;
  Buffer<float> texels_;   // the CPU's storage
  void* array_ = nullptr;  // the GPU's
  unsigned long long texture_object_ = 0;
};

}  // namespace gvx::exec
