#include "gvx/render/frame/frame.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "gvx/core/box_parts.h"
#include "gvx/core/node_key.h"

namespace gvx::render {
namespace {

constexpr std::uint32_t kLargestPicture = 32768;

template <typename T>
exec::Buffer<T> upload(const exec::Device& device, const std::vector<T>& values) {
  exec::Buffer<T> buffer(device, values.size());
  std::copy(values.begin(), values.end(), buffer.view().begin());
  return buffer;
}

bool scalar_composite(const View& view, const tree::TreeDescription& tree) {
  return view.mode == scene::Mode::composite && tree.format.content == VoxelContent::scalar;
}

Status check(const View& view, const tree::TreeDescription& tree) {
  if (!(view.samples_per_voxel >= 1 && view.samples_per_voxel <= 1000)) {
    return Error{"samples per voxel: must be between 1 and 1000"};
  }
  if (!(view.detail >= View::kLeastDetail && view.detail <= View::kMostDetail))
    return Error{"detail: must be between 0.25 and 16"};
  for (int axis = 0; axis < 3; ++axis) {
    if (!(view.clip.minimum[axis] < view.clip.maximum[axis])) {
      return Error{"clip box: each minimum must be below its maximum"};
    }
  }
  const bool scalar = tree.format.content == VoxelContent::scalar;
  if (view.mode != scene::Mode::composite && !scalar) {
    return Error{std::string("mode: a volume of ") + content_name(tree.format.content) +
                 " voxels can only be composited"};
  }
  if (view.classification != scene::Classification::preintegrated && !scalar_composite(view, tree)) {
    return Error{"classification: only scalars that are composited are classified after sampling"};
  }
  if (view.noise && (!scalar || tree.format.planes != 1)) {
    return Error{"noise: can only be added to a volume of one channel"};
  }
  if (view.mode == scene::Mode::isosurface && tree.format.planes != 1) {
    return Error{"mode: an isosurface needs a volume of one channel"};
  }
  if (view.lighting.lights < 0 || view.lighting.lights > scene::Lighting::kMostLights) {
    return Error{"lights: at most " + std::to_string(scene::Lighting::kMostLights)};
  }
  GVX_TRY(scene::check(view.lighting));
  const bool has_function = scalar || tree.format.content == VoxelContent::labels;
  if (has_function && view.functions.empty()) return Error{"transfer function: none given"};
  for (const scene::TransferFunction& function : view.functions) GVX_TRY(scene::check(function));
  return {};
}

/// Of stored values: where physical ones fall as those rise, the greatest is the least.
scene::Mode mode_of_stored(scene::Mode mode, double scale) {
  if (scale >= 0) return mode;
  return mode == scene::Mode::maximum   ? scene::Mode::minimum
         : mode == scene::Mode::minimum ? scene::Mode::maximum
                                        : mode;
}

/// The physical values that rays may find in a channel.
scene::ValueSpan values_of(const tree::TreeDescription& tree, const scene::Visibility& visibility,
                           std::uint32_t channel) {
  const ValueRange stored = visibility.widened(tree.range_of_voxels(channel));
  const double a = tree.scale * double(stored.minimum) + tree.offset;
  const double b = tree.scale * double(stored.maximum) + tree.offset;
  if (!std::isfinite(a) || !std::isfinite(b)) return {};
  return {std::min(a, b), std::max(a, b)};
}

FrameView::Extreme extreme_of(const scene::Visibility& visibility, ValueRange stored) {
  const ValueRange all = visibility.widened(stored);
  // Its inverse is a number, too.
  constexpr double kLeast = 1e-37, kMost = 1e37;
  const auto span = static_cast<float>(std::clamp(double(all.maximum) - double(all.minimum), kLeast, kMost));
  if (visibility.mode == scene::Mode::maximum) return {all.minimum, span, 1 / span};
  return {all.maximum, -span, 1 / span};
}

/// Of a voxel of the finest level, in the world.
Vec3d spacing_of(const tree::TreeDescription& tree) {
  const double voxels = nodes_across(static_cast<int>(tree.n), tree.max_level) * tree.m;
  const Affine3& place = tree.tree_to_world;
  return Vec3d(length(place.column[0]), length(place.column[1]), length(place.column[2])) / voxels;
}

/// How far the volume reaches from the eye.
double farthest(const Box3d& extent, const Affine3& tree_to_world, Vec3dd eye_world) {
  double farthest = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3d p = box_corner(extent, corner);
    farthest = std::max(farthest, length(Vec3d(point(tree_to_world, Vec3dd(p)) - eye_world)));
  }
  return farthest;
}

void set_gradient_lengths(FrameView& v) {
  const Affine3& m = v.world_to_tree;
  const auto product = [&](int a, int b) {
    double sum = 0;
    for (const Vec3d& column : m.column) sum += column[a] * column[b];
    return sum;
  };
  const Vec3d square(product(0, 0), product(1, 1), product(2, 2));
  // The sine of an angle that rounding may leave between axes at right angles.
  constexpr double kStraight = 1e-7;
  const auto mixed = [&](int a, int b) {
    const double sum = 2 * product(a, b);
    return std::abs(sum) > kStraight * std::sqrt(square[a] * square[b]) ? sum : 0.0;
  };
  v.gradient_square = Vec3f(square);
  v.gradient_product = Vec3f(Vec3d(mixed(1, 2), mixed(2, 0), mixed(0, 1)));
}

}  // namespace

Result<FilmView> film_of(const View& view) {
  if (view.width < 1 || view.height < 1 || view.width > kLargestPicture || view.height > kLargestPicture) {
    return Error{"picture size: " + std::to_string(view.width) + "x" + std::to_string(view.height) +
                 " is not between 1x1 and 32768x32768"};
  }
  if (view.antialias < 1 || view.antialias > View::kMostAntialias)
    return Error{"antialias: must be from 1 to 8"};
  FilmView film;
  film.width = view.width * view.antialias;
  film.height = view.height * view.antialias;
  GVX_ASSIGN(film.camera, scene::make_view(view.camera, film.width, film.height));
  return film;
}

std::uint32_t subrays_of(const View& view, const tree::TreeDescription& tree) {
  if (!scene::seeks_extreme(view.mode) || !view.level_of_detail) return 1;
  const auto fits = [&](std::uint32_t subrays) {
    constexpr std::uint64_t kMostRays = std::uint64_t(1) << 22;
    const std::uint64_t rays = std::uint64_t(subrays) * view.antialias;
    // Two subrays may make twice as many rays, so that a picture of 1920 x 1080 gets them.
    return rays <= View::kMostAntialias &&
           view.width * rays * view.height * rays <= (subrays > 2 ? kMostRays : 2 * kMostRays);
  };
  std::uint32_t subrays = kMostSubrays;
  while (subrays > 1 && !fits(subrays)) --subrays;
  const auto camera =
      scene::make_view(view.camera, view.width * view.antialias, view.height * view.antialias);
  if (!camera.ok()) return 1;  // Frame::make says what is wrong
  double cone = camera.value().pixel;
  if (!camera.value().orthographic) {
    cone *= farthest(tree.extent, tree.tree_to_world, view.camera.eye_world());
  }
  return cone > view.detail * max_component(spacing_of(tree)) ? subrays : 1;
}

Result<Frame> Frame::make(const exec::Device& device, const View& view, const tree::TreeDescription& tree,
                          const Frame* previous) {
  GVX_ASSIGN(const FilmView film, film_of(view));
  GVX_TRY(check(view, tree));
  GVX_CHECK(tree.max_level < kMaxLevels);
  const int n = static_cast<int>(tree.n), max_level = static_cast<int>(tree.max_level);
  Frame frame;
  FrameView& v = frame.view_;
  v.world_to_tree = inverse(tree.tree_to_world);
  frame.visible_ = intersect(box_part(tree.extent, view.clip), tree.extent);
  v.format = tree.format;

  const Vec3d spacing = spacing_of(tree);
  set_gradient_lengths(v);
  v.tick_world = min_component(spacing) / view.samples_per_voxel;
  v.voxels_per_step = static_cast<float>(1 / view.samples_per_voxel);
  v.max_level = max_level;
  v.finest_voxel = 1 / (nodes_across(static_cast<int>(tree.n), tree.max_level) * tree.m);
  v.adds_noise = view.noise.has_value();
  if (view.noise) {
    v.noise = *view.noise;
    v.visibility.noise_reach = static_cast<float>(v.noise.most());
    v.visibility.noise_fades = v.noise.fades;
  }

  // Means hide the greatest values, so these are sought on finer levels: as fine as with the most subrays,
  // or, without any, half as wide.
  const double finer = !scene::seeks_extreme(view.mode) ? 1
                       : view.subrays > 1               ? double(kMostSubrays) / view.subrays
                                                        : 2;
  frame.finest_width_ = finer * view.detail * max_component(spacing);
  frame.finest_alone_ = !view.level_of_detail;
  double stride = 1;
  for (int level = max_level; level >= 0; --level, stride *= n) {
    v.stride[level] = stride;
    v.gradient_scale[level] = static_cast<float>(1 / std::sqrt(std::min(stride, 4.0)));
  }
  frame.bundle_ = frame.bundle_at(device, tree, view.camera.eye_world(), film.camera.cones());
  v = frame.view_from(frame.bundle_);

  const scene::TransferFunction none{{{0, {}}}, {{0, 0}}, 0, {}};
  const double unit_distance = view.functions.empty() ? 0 : view.functions[0].unit_distance;
  const double unit = unit_distance > 0 ? unit_distance : min_component(spacing);
  v.units_per_tick = static_cast<float>(v.tick_world / unit);
  // A step of the finest level through the most opaque matter leaves less than RayMarcher looks at.
  const double most_extinction = std::clamp(8 * unit / v.tick_world, 16.0, 1e6);
  v.visibility.mode = mode_of_stored(view.mode, tree.scale);
  v.visibility.channels = tree.format.channels();
  for (std::uint32_t c = 0; c < v.visibility.channels; ++c) {
    const scene::TransferFunction& function =
        view.functions.empty() ? none : view.functions[std::min<std::size_t>(c, view.functions.size() - 1)];
    const scene::ValueSpan values = values_of(tree, v.visibility, c);
    v.extreme[c] = extreme_of(v.visibility, tree.range_of_voxels(c));
    std::shared_ptr<const Tables> tables;
    if (previous != nullptr && c < previous->tables_.size()) {
      const Tables& before = *previous->tables_[c];
      if (before.function == function && before.values == values &&
          before.most_extinction == most_extinction) {
        tables = previous->tables_[c];
      }
    }
    if (tables == nullptr) tables = make_tables(device, function, tree, values, most_extinction);
    v.visibility.functions[c] = tables->view;
    // Its inverse is a number, too.
    constexpr float kLeastGradient = 1e-36f;
    v.soft_gradient[c] = std::max(static_cast<float>(scene::kSoftGradient * tables->span), kLeastGradient);
    frame.tables_.push_back(std::move(tables));
  }
  v.classification = view.classification;
  // No step is longer than a voxel of the brick that it is in.
  v.blends_in_long_steps = v.classification == scene::Classification::preintegrated &&
                           scalar_composite(view, tree) && !v.adds_noise &&
                           static_cast<float>(n) * v.voxels_per_step <= 1;
  const bool by_gradient = v.visibility.functions[0].gradient_factor != nullptr;
  if (v.classification == scene::Classification::post && scalar_composite(view, tree) &&
      v.visibility.channels == 1 && !by_gradient && !v.adds_noise && device.kind() == exec::DeviceKind::cpu) {
    const auto& before = previous != nullptr ? previous->steps_ : nullptr;
    const std::vector<double> strides(v.stride, v.stride + v.max_level + 1);
    const bool same = before != nullptr && before->tables == frame.tables_[0] &&
                      before->units_per_tick == v.units_per_tick && before->strides == strides;
    frame.steps_ = same ? before : make_steps(v, frame.tables_[0]);
    v.step_colors = frame.steps_->colors.data();
  }
  v.visibility.isovalue = static_cast<float>((view.isovalue - tree.offset) / tree.scale);
  if (view.mode == scene::Mode::isosurface) v.iso_color = Vec3f(view.functions[0].color(view.isovalue));
  v.lighting = scene::place_lights(view.lighting, film.camera.forward, film.camera.right, film.camera.up);
  return frame;
}

Bundle Frame::bundle_at(const exec::Device& device, const tree::TreeDescription& tree, Vec3dd origin,
                        ConeShape cones) const {
  return {device, tree, visible_, origin, cones, {finest_width_, view_.stride, finest_alone_}};
}

FrameView Frame::view_from(const Bundle& bundle) const {
  FrameView view = view_;
  view.bundle = bundle.view();
  return view;
}

std::shared_ptr<const Frame::Tables> Frame::make_tables(const exec::Device& device,
                                                        const scene::TransferFunction& function,
                                                        const tree::TreeDescription& tree,
                                                        scene::ValueSpan values, double most_extinction) {
  scene::TransferTable table;
  switch (tree.format.content) {
    case VoxelContent::scalar:
      table = scene::bake(function, tree.scale, tree.offset, most_extinction, values);
      break;
    case VoxelContent::labels:
      table = scene::bake_labels(function, tree.scale, tree.offset,
                                 static_cast<std::uint32_t>(tree.range_of_voxels(0).maximum) + 1);
      break;
    default:
      table = scene::bake_opacities();
  }
  auto tables = std::make_shared<Tables>();
  tables->function = function;
  tables->values = values;
  tables->span = table.span;
  tables->most_extinction = most_extinction;
  tables->matter = upload(device, table.matter);
  tables->integral = upload(device, table.integral);
  tables->visible_before = upload(device, table.visible_before);
  tables->gradient_factor = upload(device, table.gradient_factor);
  tables->view = table.view();
  tables->view.matter = tables->matter.view().data;
  tables->view.integral = tables->integral.view().data;
  tables->view.visible_before = tables->visible_before.view().data;
  if (tables->view.gradient_factor != nullptr) {
    tables->view.gradient_factor = tables->gradient_factor.view().data;
  }
  return tables;
}

std::shared_ptr<const Frame::StepTable> Frame::make_steps(const FrameView& view,
                                                          std::shared_ptr<const Tables> tables) {
  auto steps = std::make_shared<StepTable>();
  steps->tables = std::move(tables);
  steps->units_per_tick = view.units_per_tick;
  steps->strides.assign(view.stride, view.stride + view.max_level + 1);
  const scene::TransferView& function = steps->tables->view;
  const auto entries = static_cast<std::size_t>(function.entries);
  steps->colors.resize(steps->strides.size() * entries);
  for (std::size_t level = 0; level < steps->strides.size(); ++level) {
    const float units = view.units_per_tick * static_cast<float>(steps->strides[level]);
    for (std::size_t entry = 0; entry < entries; ++entry) {
      const scene::Matter& m = function.matter[entry];
      if (!(m.extinction > 0.0f)) continue;
      steps->colors[level * entries + entry] = {m.color / m.extinction, 1 - std::exp(-m.extinction * units)};
    }
  }
  return steps;
}

}  // namespace gvx::render
