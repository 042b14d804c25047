#include "gvx/io/mesh.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "gvx/io/header_text.h"
#include "gvx/io/mesh_gltf.h"
#include "gvx/io/mesh_obj.h"
#include "gvx/io/mesh_ply.h"
#include "gvx/io/mesh_stl.h"
#include "gvx/io/polygon.h"

namespace gvx::io {
namespace {

struct MeshFormat {
  const char* ending;
  const char* name;
  UpAxis up;
  Status (*stream)(const std::string& path, MeshSink& sink, const MeshProgress& progress);
};

constexpr const char* kGltf = "glTF";

constexpr std::array<MeshFormat, 6> kFormats = {{{".ply", "PLY", UpAxis::y, stream_ply},
                                                 {".ply.gz", "PLY", UpAxis::y, stream_ply},
                                                 {".obj", "OBJ", UpAxis::y, stream_obj},
                                                 {".stl", "STL", UpAxis::z, stream_stl},
                                                 {".gltf", kGltf, UpAxis::y, stream_gltf},
                                                 {".glb", kGltf, UpAxis::y, stream_gltf}}};

const MeshFormat* format_of(const std::string& path) {
  const std::string name = lower_case(path);
  const auto found = std::find_if(kFormats.begin(), kFormats.end(),
                                  [&](const MeshFormat& format) { return name.ends_with(format.ending); });
  return found == kFormats.end() ? nullptr : &*found;
}

/// Keeps what covers anything, and counts what does not.
class MeshCollector final : public MeshSink {
 public:
  Status add_vertices(std::span<const Vec3d> places, std::span<const Vec3f> colors) override {
    places_.insert(places_.end(), places.begin(), places.end());
    if (!colors.empty()) {
      colors_.resize(places_.size() - places.size(), Vec3f(0.8f));
      colors_.insert(colors_.end(), colors.begin(), colors.end());
    } else if (!colors_.empty()) {
      colors_.resize(places_.size(), Vec3f(0.8f));
    }
    return {};
  }

  Status add_triangles(std::span<const Triangle> triangles, std::span<const Vec3f>) override {
    for (const Triangle& t : triangles) {
      const bool there = std::all_of(t.begin(), t.end(), [&](std::uint32_t v) { return v < places_.size(); });
      if (there && has_area(places_[t[0]], places_[t[1]], places_[t[2]])) {
        triangles_.push_back(t);
      } else {
        ++dropped_;
      }
    }
    return {};
  }

  Result<Vec3d> place(std::uint32_t vertex) override {
    return vertex < places_.size() ? places_[vertex] : Vec3d(std::numeric_limits<double>::quiet_NaN());
  }

  void pass_over(const std::string&) override {}

  std::uint64_t dropped() const { return dropped_; }

  /// Without vertices that no triangle has.
  TriangleMesh take() {
    constexpr std::uint32_t kUnused = UINT32_MAX;
    std::vector<std::uint32_t> index(places_.size(), kUnused);
    TriangleMesh used;
    used.origin = origin();
    for (Triangle& triangle : triangles_) {
      for (std::uint32_t& v : triangle) {
        if (index[v] == kUnused) {
          index[v] = static_cast<std::uint32_t>(used.vertices.size());
          used.vertices.emplace_back(places_[v] - used.origin);
          if (!colors_.empty()) used.colors.push_back(colors_[v]);
        }
        v = index[v];
      }
    }
    used.triangles = std::move(triangles_);
    return used;
  }

 private:
  /// The mesh's least corner where that is farther from 0 than the mesh is large.
  Vec3d origin() const {
    Box3d box{Vec3d(INFINITY), Vec3d(-INFINITY)};
    double farthest = 0;
    for (const Triangle& triangle : triangles_) {
      for (const std::uint32_t v : triangle) {
        for (int axis = 0; axis < 3; ++axis) {
          box.minimum[axis] = std::min(box.minimum[axis], places_[v][axis]);
          box.maximum[axis] = std::max(box.maximum[axis], places_[v][axis]);
          farthest = std::max(farthest, std::fabs(places_[v][axis]));
        }
      }
    }
    return farthest > 2 * max_component(box.maximum - box.minimum) && !box.empty() ? box.minimum : Vec3d();
  }

  std::vector<Vec3d> places_;
  std::vector<Vec3f> colors_;
  std::vector<Triangle> triangles_;
  std::uint64_t dropped_ = 0;
};

}  // namespace

bool has_area(Vec3d a, Vec3d b, Vec3d c) {
  // Infinite or undefined where a place is.
  const double twice = length(cross(b - a, c - a));
  return twice > 0 && std::isfinite(twice);
}

Status cut_polygon(MeshSink& sink, std::span<const std::uint32_t> corners, std::vector<Triangle>& triangles) {
  if (corners.size() == 3) triangles.push_back({corners[0], corners[1], corners[2]});
  if (corners.size() < 4) return {};
  std::vector<std::uint32_t> ring;
  std::vector<Vec3d> places;
  for (const std::uint32_t v : corners) {
    // A corner that is repeated has no side of its own.
    if (ring.empty() ? v == corners.back() : v == ring.back()) continue;
    ring.push_back(v);
    GVX_ASSIGN(places.emplace_back(), sink.place(v));
  }
  std::vector<Triangle> cut;
  cut_polygon(places, cut);
  for (const auto& [a, b, c] : cut) triangles.push_back({ring[a], ring[b], ring[c]});
  return {};
}

Box3d TriangleMesh::bounds() const {
  Box3d box{Vec3d(INFINITY), Vec3d(-INFINITY)};
  for (const auto& triangle : triangles) {
    for (const std::uint32_t v : triangle) {
      const Vec3d at = place(v);
      for (int axis = 0; axis < 3; ++axis) {
        box.minimum[axis] = std::min(box.minimum[axis], at[axis]);
        box.maximum[axis] = std::max(box.maximum[axis], at[axis]);
      }
    }
  }
  return box;
}

MeshUp mesh_up(const std::string& path, const Box3d& bounds) {
  const MeshFormat* format = format_of(path);
  if (format == nullptr) return {UpAxis::z, true, "as its format is not known"};
  if (format->name == kGltf) return {UpAxis::y, false, "by the specification of glTF"};
  // In the mesh's sizes: of a map's coordinates from 0, and of what stands on a plane from it.
  constexpr double kFar = 10, kLow = 1.0 / 30;
  const double size = max_component(bounds.maximum - bounds.minimum);
  const auto is_far = [&](int axis) {
    return std::max(bounds.minimum[axis], -bounds.maximum[axis]) > kFar * size;
  };
  const auto stands_on = [&](int up, int other) {
    const double depth = bounds.maximum[other] - bounds.minimum[other];
    const bool middle = -bounds.minimum[other] > depth / 4 && bounds.maximum[other] > depth / 4;
    return std::fabs(bounds.minimum[up]) <= kLow * size && bounds.maximum[up] > kLow * size && middle;
  };
  if (is_far(0) && is_far(1)) return {UpAxis::z, true, "as its coordinates are as far from 0 as a map's"};
  if (stands_on(1, 2)) return {UpAxis::y, true, "as it stands on y = 0"};
  if (stands_on(2, 1)) return {UpAxis::z, true, "as it stands on z = 0"};
  return {format->up, true, std::string("as in most ") + format->name + " files"};
}

bool is_mesh_name(const std::string& path) {
  return format_of(path) != nullptr;
}

Status stream_mesh(const std::string& path, MeshSink& sink, const MeshProgress& progress) {
  const MeshFormat* format = format_of(path);
  if (format == nullptr) {
    std::string known;
    for (const MeshFormat& one : kFormats) known += std::string(known.empty() ? "" : ", ") + one.ending;
    return Error{path + ": not a mesh by its name, which would end in one of " + known};
  }
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return Error{path + ": cannot open: no such file"};
  return format->stream(path, sink, progress);
}

Result<TriangleMesh> read_mesh(const std::string& path, MeshReport* report) {
  MeshCollector collector;
  GVX_TRY(stream_mesh(path, collector));
  if (report != nullptr) report->dropped = collector.dropped();
  TriangleMesh mesh = collector.take();
  if (mesh.triangles.empty()) return no_triangle(path, collector.dropped());
  return mesh;
}

Error no_triangle(const std::string& path, std::uint64_t dropped) {
  if (dropped == 0) return Error{path + ": there is no triangle in it"};
  return Error{path + ": there is no triangle in it that covers anything; left out: " +
               std::to_string(dropped) + " without an area, or with a vertex that is missing or not finite"};
}

}  // namespace gvx::io
