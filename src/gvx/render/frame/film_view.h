/// \file
/// FilmView: the rays of a picture. What they meet of an object says the object's FrameView.
#pragma once

#include <cstddef>
#include <cstdint>

#include "gvx/core/ray.h"
#include "gvx/render/frame/bundle_view.h"
#include "gvx/scene/camera.h"

namespace gvx::render {

struct FilmView {
  scene::CameraView camera;
  std::uint32_t width = 0, height = 0;  ///< in rays
  /// Of each ray between which distances it sees anything, or null: a proxy's (scene/proxy.h). What is cut
  /// off makes no difference to a picture; steps are those that they are without.
  const RayInterval* proxy = nullptr;

  GVX_HD std::size_t index(std::uint32_t x, std::uint32_t y) const { return std::size_t(y) * width + x; }
  /// Ray (x, y). They need not be whole numbers; a proxy is told the whole numbers below.
  GVX_HD BundleRay ray(double x, double y) const {
    const bool cut = proxy != nullptr && x < width && y < height;
    return {camera.pixel_ray_from_eye(x, y),
            cut ? proxy + index(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y)) : nullptr};
  }
};

}  // namespace gvx::render
