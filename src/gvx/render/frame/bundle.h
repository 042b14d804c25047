/// \file
/// Bundle: owns the levels behind a BundleView.
#pragma once

#include "gvx/core/double_double.h"
#include "gvx/exec/buffer.h"
#include "gvx/exec/device.h"
#include "gvx/render/frame/bundle_view.h"
#include "gvx/tree/tree_description.h"

namespace gvx::render {

/// How wide a cone is to be for the levels of a tree: for level l as wide as finest * stride[l].
struct LevelWidths {
  double finest = 0;
  const double* stride = nullptr;  ///< N^(max_level - l)
  bool finest_alone = false;       ///< everywhere the finest level, however wide cones are
};

class Bundle {
 public:
  Bundle() = default;
  /// Of rays from around `origin`, in the world, through the part `visible` of a tree, which is in tree space
  /// and not empty.
  Bundle(const exec::Device& device, const tree::TreeDescription& tree, const Box3d& visible, Vec3dd origin,
         ConeShape cones, const LevelWidths& widths);

  BundleView view() const { return view_; }

 private:
  BundleView view_;
  exec::Buffer<LevelView> levels_;
};

}  // namespace gvx::render
