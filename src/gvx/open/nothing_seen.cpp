#include "gvx/open/nothing_seen.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <vector>

namespace gvx::open {
namespace {

constexpr float kFaintest = 0.5f / 255;  // what is fainter leaves no trace in 8 bits

std::string text_of(double v) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", v);
  return text;
}

std::string text_of(Vec3d v) {
  return "(" + text_of(v.x) + ", " + text_of(v.y) + ", " + text_of(v.z) + ")";
}

/// How far the picture is from showing nothing, 0 to 1.
float most_seen(const render::Picture& picture, const render::View& view) {
  float most = 0;
  for (std::size_t i = 0; i < picture.rgba.size(); i += 4) {
    if (!view.opaque_background) {
      most = std::max(most, picture.rgba[i + 3]);
      continue;
    }
    for (int c = 0; c < 3; ++c) {
      most = std::max(most, std::abs(picture.rgba[i + static_cast<std::size_t>(c)] - view.background[c]));
    }
  }
  return most;
}

struct Values {
  double minimum = 0, maximum = 0;

  std::string text() const { return text_of(minimum) + " to " + text_of(maximum); }
};

/// Physical.
Values values_of(const produce::TreeDescription& tree, std::uint32_t channel) {
  const ValueRange stored = tree.ranges.channel[channel];
  const double a = tree.scale * stored.minimum + tree.offset, b = tree.scale * stored.maximum + tree.offset;
  return {std::min(a, b), std::max(a, b)};
}

/// "it shows values from 5 to 10".
std::string visible_values(const scene::TransferFunction& function) {
  const auto& points = function.opacities;
  const auto seen = [](const scene::OpacityPoint& p) { return p.opacity > 0; };
  const auto first = std::find_if(points.begin(), points.end(), seen);
  const auto last = std::find_if(points.rbegin(), points.rend(), seen);
  if (first == points.end()) return "it shows no value";
  const std::string text = "it shows values";
  const bool from_below = first == points.begin(), to_above = last == points.rbegin();
  if (from_below) return text + " below " + text_of((last - 1)->value);
  if (to_above) return text + " above " + text_of((first - 1)->value);
  return text + " from " + text_of((first - 1)->value) + " to " + text_of((last - 1)->value);
}

/// Of values that are nowhere in the volume.
std::optional<std::string> wrong_values(const render::View& view, const produce::TreeDescription& tree) {
  if (view.noise) return std::nullopt;
  if (view.mode == scene::Mode::isosurface) {
    const Values values = values_of(tree, 0);
    if (view.isovalue >= values.minimum && view.isovalue <= values.maximum) return std::nullopt;
    return "isovalue " + text_of(view.isovalue) + " is outside the volume's values, " + values.text();
  }
  if (view.functions.empty()) {
    if (tree.ranges.channel[0].maximum > 0) return std::nullopt;
    return "the volume's colours are transparent everywhere";
  }
  const std::uint32_t channels = tree.format.channels();
  std::string text;
  for (std::uint32_t c = 0; c < channels; ++c) {
    const auto& function = view.functions[std::min<std::size_t>(c, view.functions.size() - 1)];
    const Values values = values_of(tree, c);
    if (!function.transparent(values.minimum, values.maximum)) return std::nullopt;
    const std::string of_channel = channels > 1 ? " of channel " + std::to_string(c + 1) : "";
    text += (text.empty() ? "" : "; ") + ("the transfer function" + of_channel) +
            " is transparent over all of the volume's values, " + values.text() + "; " +
            visible_values(function);
  }
  return text;
}

/// The corners of a box of tree space, in the world.
std::array<Vec3d, 8> corners_of(const Box3d& box, const Affine3& tree_to_world) {
  std::array<Vec3d, 8> corners;
  for (int i = 0; i < 8; ++i) {
    corners[static_cast<std::size_t>(i)] =
        tree_to_world.point({i & 1 ? box.maximum.x : box.minimum.x, i & 2 ? box.maximum.y : box.minimum.y,
                             i & 4 ? box.maximum.z : box.minimum.z});
  }
  return corners;
}

bool meets_a_ray(const scene::CameraView& camera, const render::View& view, const Box3d& box,
                 const Affine3& world_to_tree) {
  const std::uint32_t k = view.antialias;
  for (std::uint32_t y = 0; y < view.height * k; ++y) {
    for (std::uint32_t x = 0; x < view.width * k; ++x) {
      const Ray world = camera.pixel_ray(x, y);
      const Ray ray{world_to_tree.point(world.origin), world_to_tree.vector(world.direction)};
      if (!intersect(ray, box, 0, std::numeric_limits<double>::infinity()).empty()) return true;
    }
  }
  return false;
}

/// Of a camera that looks elsewhere; `box` is what can be seen of the volume, in tree space.
std::optional<std::string> wrong_camera(const render::View& view, const produce::TreeDescription& tree,
                                        const Box3d& box) {
  const std::uint32_t k = view.antialias;
  const auto made = scene::make_view(view.camera, view.width * k, view.height * k);
  if (!made.ok()) return std::nullopt;
  const scene::CameraView& camera = made.value();
  if (meets_a_ray(camera, view, box, inverse(tree.tree_to_world))) return std::nullopt;
  const Vec3d centre = tree.tree_to_world.point(0.5 * (box.minimum + box.maximum));
  const std::string where = ", whose centre is at " + text_of(centre);
  const auto depth = [&](Vec3d p) { return dot(p - camera.eye, camera.forward); };
  const auto corners = corners_of(box, tree.tree_to_world);
  if (std::all_of(corners.begin(), corners.end(), [&](Vec3d p) { return depth(p) <= 0; })) {
    return "the volume" + where + ", is behind the camera";
  }
  const double scale = camera.orthographic ? 1 : depth(centre);
  const double x = dot(centre - camera.eye, camera.right) / (scale * camera.pixel);
  const double y = dot(centre - camera.eye, camera.up) / (scale * camera.pixel);
  if (depth(centre) > 0 && std::abs(x) <= camera.half_width && std::abs(y) <= camera.half_height) {
    return "the volume" + where + ", is smaller than a pixel";
  }
  return "the camera looks past the volume" + where;
}

bool is_dark(const render::View& view) {
  const scene::Lighting& lighting = view.lighting;
  const bool lit = view.mode == scene::Mode::composite || view.mode == scene::Mode::isosurface;
  return lit && lighting.enabled && !(lighting.ambient > 0) &&
         (lighting.lights == 0 || (!(lighting.diffuse > 0) && !(lighting.specular > 0)));
}

}  // namespace

std::optional<std::string> why_nothing_is_seen(const render::Picture& picture, const render::View& view,
                                               const produce::TreeDescription& tree, bool exact, bool proxy) {
  const float most = most_seen(picture, view);
  if (most >= kFaintest) return std::nullopt;
  const Vec3d size = tree.extent.maximum - tree.extent.minimum;
  const Box3d box = intersect(
      Box3d{tree.extent.minimum + view.clip.minimum * size, tree.extent.minimum + view.clip.maximum * size},
      tree.extent);
  for (int axis = 0; axis < 3; ++axis) {
    if (!(box.minimum[axis] < box.maximum[axis])) {
      return "the clip box, " + text_of(view.clip.minimum) + " to " + text_of(view.clip.maximum) +
             ", lies outside the volume, which goes from 0 to 1";
    }
  }
  if (auto values = wrong_values(view, tree)) return values;
  if (auto camera = wrong_camera(view, tree, box)) return camera;
  if (!exact) return std::nullopt;
  if (most > 0) return "all that is seen is too faint: at most " + text_of(double(most)) + " of 1";
  if (view.opaque_background && is_dark(view)) return std::string("no light falls on what is seen");
  const std::string where = proxy ? "within the proxy mesh where the camera looks" : "where the camera looks";
  if (view.mode == scene::Mode::isosurface) {
    return "no surface of isovalue " + text_of(view.isovalue) + " is " + where;
  }
  return "all that is " + where + " is transparent" +
         (view.opaque_background ? ", or has the background's colour" : "");
}

}  // namespace gvx::open
