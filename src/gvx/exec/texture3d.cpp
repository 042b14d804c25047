#include "gvx/exec/texture3d.h"

#include <algorithm>
#include <utility>

namespace gvx::exec {

#if defined(__CUDACC__)
namespace {

struct GpuTexture {
  cudaArray_t array = nullptr;
  cudaTextureObject_t object = 0;
};

GpuTexture upload(Vec3u size, const float* texels) {
  GpuTexture texture;
  const cudaChannelFormatDesc format = cudaCreateChannelDesc<float>();
  const cudaExtent extent = make_cudaExtent(size.x, size.y, size.z);
  GVX_CHECK(cudaMalloc3DArray(&texture.array, &format, extent) == cudaSuccess);
  cudaMemcpy3DParms copy{};
  copy.srcPtr = make_cudaPitchedPtr(const_cast<float*>(texels), size.x * sizeof(float), size.x, size.y);
  copy.dstArray = texture.array;
  copy.extent = extent;
  copy.kind = cudaMemcpyHostToDevice;
  GVX_CHECK(cudaMemcpy3D(&copy) == cudaSuccess);

  cudaResourceDesc resource{};
  resource.resType = cudaResourceTypeArray;
  resource.res.array.array = texture.array;
  cudaTextureDesc description{};
  description.addressMode[0] = description.addressMode[1] = description.addressMode[2] = cudaAddressModeClamp;
  description.filterMode = cudaFilterModeLinear;
  description.readMode = cudaReadModeElementType;
  GVX_CHECK(cudaCreateTextureObject(&texture.object, &resource, &description, nullptr) == cudaSuccess);
  return texture;
}

}  // namespace
#endif

Texture3D::Texture3D(const Device& device, Vec3u size, std::span<const float> texels) : size_(size) {
  GVX_CHECK(texels.size() == std::size_t(size.x) * size.y * size.z && !texels.empty());
#if defined(__CUDACC__)
  if (device.kind() == DeviceKind::cuda) {
    const GpuTexture texture = upload(size, texels.data());
    array_ = texture.array;
    texture_object_ = texture.object;
    return;
  }
#endif
  texels_ = Buffer<float>(device, texels.size());
  std::copy(texels.begin(), texels.end(), texels_.view().begin());
}

Texture3D::Texture3D(Texture3D&& other) noexcept
    : size_(other.size_),
      texels_(std::move(other.texels_)),
      array_(std::exchange(other.array_, nullptr)),
      texture_object_(std::exchange(other.texture_object_, 0)) {}

Texture3D::~Texture3D() {
#if defined(__CUDACC__)
  if (array_ != nullptr) {
    cudaDestroyTextureObject(static_cast<cudaTextureObject_t>(texture_object_));
    cudaFreeArray(static_cast<cudaArray_t>(array_));
  }
#endif
}

Texture3DView Texture3D::view() const {
  return {texels_.view().data, size_.x, size_.y, size_.z, texture_object_};
}

}  // namespace gvx::exec
