#include "gvx/mesh/corner_normals.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace gvx::mesh {
namespace {

/// Between triangles that turn by more than this the surface has an edge: the cosine of 45 degrees.
constexpr float kEdge = 0.7071f;
/// A hub of very many triangles would take the square of their number; its corners keep their triangles'
/// normals.
constexpr std::size_t kMostAround = 256;

Vec3f unit(Vec3f v) {
  const float size = length(v);
  return size > 0 ? v / size : Vec3f();
}

Normal16 packed(Vec3f v) {
  const auto number = [](float c) { return static_cast<std::int16_t>(std::lround(32767 * c)); };
  return {number(v.x), number(v.y), number(v.z)};
}

}  // namespace

CornerNormals::CornerNormals(const std::string& folder, std::uint64_t memory_bytes, std::uint64_t triangles)
    : folder_(folder), memory_bytes_(memory_bytes), expected_corners_(3 * triangles) {
  corners_.emplace(folder, memory_bytes / 3 * 2, expected_corners_, ByPlace());
}

Status CornerNormals::push(const std::array<Vec3f, 3>& triangle) {
  for (std::uint32_t k = 0; k < 3; ++k) {
    const Vec3f here = triangle[k];
    const Vec3f a = triangle[(k + 1) % 3] - here, b = triangle[(k + 2) % 3] - here;
    const Vec3f across = cross(a, b);
    const float angle = std::atan2(length(across), dot(a, b));
    GVX_TRY(corners_->push({3 * triangles_ + k, here, angle * unit(across)}));
  }
  ++triangles_;
  return {};
}

Status CornerNormals::smooth(std::span<const Corner> around, Normals& normals) {
  std::array<Vec3f, kMostAround> units;
  std::transform(around.begin(), around.end(), units.begin(), [](const Corner& c) { return unit(c.normal); });
  for (std::size_t i = 0; i < around.size(); ++i) {
    Vec3f sum;
    for (std::size_t j = 0; j < around.size(); ++j) {
      if (dot(units[i], units[j]) >= kEdge) sum = sum + around[j].normal;
    }
    GVX_TRY(normals.push({around[i].index, packed(unit(sum))}));
  }
  return {};
}

Status CornerNormals::for_each(const std::function<Status(const std::array<Normal16, 3>&)>& function) {
  Normals normals(folder_, memory_bytes_ / 3, expected_corners_, ByIndex());
  std::vector<Corner> around;
  bool hub = false;
  const auto end_vertex = [&]() -> Status {
    if (!hub) return smooth(around, normals);
    for (const Corner& corner : around) {
      GVX_TRY(normals.push({corner.index, packed(unit(corner.normal))}));
    }
    return {};
  };
  const auto take = [&](const Corner& corner) -> Status {
    const bool same = !around.empty() && around.front().same_place(corner);
    // Of a hub as many as may be together are held.
    if (same && around.size() == kMostAround) hub = true;
    if (!around.empty() && (!same || around.size() == kMostAround)) {
      GVX_TRY(end_vertex());
      around.clear();
    }
    if (!same) hub = false;
    around.push_back(corner);
    return {};
  };
  GVX_TRY(corners_->for_each(take));
  GVX_TRY(end_vertex());
  corners_.reset();
  std::array<Normal16, 3> triangle;
  return normals.for_each([&](const Normal& normal) -> Status {
    triangle[normal.index % 3] = normal.normal;
    return normal.index % 3 == 2 ? function(triangle) : Status();
  });
}

}  // namespace gvx::mesh
