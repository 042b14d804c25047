#include "gvx/render/frame.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gvx::render {
namespace {

constexpr std::uint32_t kLargestPicture = 32768;

template <typename T>
exec::Buffer<T> upload(const exec::Device& device, const std::vector<T>& values) {
  exec::Buffer<T> buffer(device, values.size());
  std::copy(values.begin(), values.end(), buffer.view().begin());
  return buffer;
}

Status check(const View& view) {
  if (view.width < 1 || view.height < 1 || view.width > kLargestPicture || view.height > kLargestPicture) {
    return Error{"picture size: " + std::to_string(view.width) + "x" + std::to_string(view.height) +
                 " is not between 1x1 and 32768x32768"};
  }
  if (!(view.samples_per_voxel >= 0.05 && view.samples_per_voxel <= 1000)) {
    return Error{"samples per voxel: must be between 0.05 and 1000"};
  }
  for (int axis = 0; axis < 3; ++axis) {
    if (!(view.clip.minimum[axis] < view.clip.maximum[axis])) {
      return Error{"clip box: each minimum must be below its maximum"};
    }
  }
  return scene::check(view.function);
}

}  // namespace

Result<Frame> Frame::make(const exec::Device& device, const View& view, const TreePlacement& placement,
                          const Frame* previous) {
  GVX_TRY(check(view));
  GVX_CHECK(placement.max_level < kMaxLevels);
  Frame frame;
  FrameView& v = frame.view_;
  GVX_ASSIGN(v.camera, scene::make_view(view.camera, view.width, view.height));
  v.width = view.width;
  v.height = view.height;
  v.world_to_tree = inverse(placement.tree_to_world);
  const Vec3d size = placement.extent.maximum - placement.extent.minimum;
  const Box3d clip{placement.extent.minimum + view.clip.minimum * size,
                   placement.extent.minimum + view.clip.maximum * size};
  v.box = intersect(clip, placement.extent);

  const double finest_voxels =
      nodes_across(placement.n, static_cast<std::uint32_t>(placement.max_level)) * placement.m;
  const Affine3& place = placement.tree_to_world;
  const Vec3d spacing =
      Vec3d(length(place.column[0]), length(place.column[1]), length(place.column[2])) / finest_voxels;
  v.tick_world = min_component(spacing) / view.samples_per_voxel;
  v.max_level = placement.max_level;

  // A level serves where its voxel, along its widest axis, is no wider than the cone: width = pixel * t.
  std::int64_t stride = 1;
  for (int level = placement.max_level; level >= 0; --level, stride *= placement.n) {
    v.stride[level] = stride;
    const double voxel_world = max_component(spacing) * static_cast<double>(stride);
    if (level == placement.max_level) {
      v.lod_distance[level] = 0;
    } else if (!view.level_of_detail) {
      v.lod_distance[level] = std::numeric_limits<double>::infinity();
    } else if (v.camera.orthographic) {
      v.lod_distance[level] = voxel_world <= v.camera.pixel ? 0 : std::numeric_limits<double>::infinity();
    } else {
      v.lod_distance[level] = voxel_world / v.camera.pixel;
    }
  }

  const double unit = view.function.unit_distance > 0 ? view.function.unit_distance : min_component(spacing);
  std::vector<double> step_units;
  for (int level = 0; level <= placement.max_level; ++level) {
    step_units.push_back(v.tick_world * static_cast<double>(v.stride[level]) / unit);
  }
  const bool same_tables = previous != nullptr && previous->tables_->function == view.function &&
                           previous->tables_->step_units == step_units;
  frame.tables_ =
      same_tables ? previous->tables_ : make_tables(device, view.function, placement, std::move(step_units));
  v.function = frame.tables_->view;

  v.lighting = view.lighting;
  v.to_light = Vec3f(scene::direction_to_light(v.camera.forward, v.camera.right, v.camera.up));
  // A surface crosses the function's values within a few voxels; a two-hundredth of them a voxel is noise.
  v.soft_gradient =
      static_cast<float>(scene::TransferView::kEntries / std::abs(v.function.to_entry_scale) / 200);
  return frame;
}

std::shared_ptr<const Frame::Tables> Frame::make_tables(const exec::Device& device,
                                                        const scene::TransferFunction& function,
                                                        const TreePlacement& placement,
                                                        std::vector<double> step_units) {
  const scene::TransferTable table = scene::bake(function, placement.scale, placement.offset, step_units);
  auto tables = std::make_shared<Tables>();
  tables->function = function;
  tables->step_units = std::move(step_units);
  tables->colors = upload(device, table.colors);
  tables->opacities = upload(device, table.opacities);
  tables->opaque_before = upload(device, table.opaque_before);
  tables->view = table.view();
  tables->view.colors = tables->colors.view().data;
  tables->view.opacities = tables->opacities.view().data;
  tables->view.opaque_before = tables->opaque_before.view().data;
  return tables;
}

}  // namespace gvx::render
