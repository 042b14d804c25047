// EmbreePeer: pictures of a mesh by Embree 3 (Wald and others 2014), packets of 16 coherent rays, lit as
// SurfaceDrawing lights. It is the reference for what is seen, too.
#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include "gvx/core/vec.h"
#include "gvx/exec/device.h"
#include "gvx/surface/draw/surface_drawing.h"
#include "models.h"

namespace gvx::bench {

struct PeerPixel {
  float depth = INFINITY;  ///< along the view; infinite: nothing is hit
  Vec3f color;

  bool hit() const { return depth < INFINITY; }
};

class EmbreePeer {
 public:
  /// Null where this build has no Embree. The model must live as long.
  static std::unique_ptr<EmbreePeer> create(const exec::Device& cpu, const Model& model);
  ~EmbreePeer();
  EmbreePeer(const EmbreePeer&) = delete;
  EmbreePeer& operator=(const EmbreePeer&) = delete;

  double build_seconds() const;
  /// What Embree holds now, the mesh left out.
  std::uint64_t bytes() const;
  void draw(const surface::SurfaceView& view, std::vector<PeerPixel>& pixels) const;

 private:
  struct Scene;
  EmbreePeer();

  std::unique_ptr<Scene> scene_;
};

}  // namespace gvx::bench
