#include "gvx/surface/triangle_list.h"

#include <algorithm>
#include <limits>

namespace gvx::surface {
namespace {

bool is_narrow(const Vec3<std::int32_t>& place) {
  using Narrow = std::numeric_limits<std::int16_t>;
  const auto fits = [](std::int32_t v) { return v >= Narrow::min() && v <= Narrow::max(); };
  return fits(place.x) && fits(place.y) && fits(place.z);
}

}  // namespace

std::size_t TriangleList::Hash::operator()(const TriangleVertex& vertex) const {
  std::uint64_t attributes = 0;
  std::memcpy(&attributes, &vertex.attributes, sizeof(vertex.attributes));
  std::uint64_t hash = attributes;
  for (int axis = 0; axis < 3; ++axis) {
    hash ^= static_cast<std::uint32_t>(vertex.place[axis]);
    hash *= 0xff51afd7ed558ccdull;
    hash ^= hash >> 32;
  }
  return static_cast<std::size_t>(hash);
}

void TriangleList::add(const std::array<TriangleVertex, 3>& triangle) {
  std::array<std::uint32_t, 3> corners{};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto [found, is_new] = number_of_.try_emplace(triangle[i], vertices());
    if (is_new) vertices_.push_back(triangle[i]);
    corners[i] = found->second;
    wide_ = wide_ || !is_narrow(triangle[i].place);
  }
  corners_.push_back(corners);
}

std::vector<std::byte> TriangleList::bytes() const {
  std::vector<std::byte> bytes(TriangleListView::size(vertices(), triangles(), wide_));
  std::byte* to = bytes.data();
  const auto put = [&](const auto& value, std::size_t size) {
    std::memcpy(to, &value, size);
    to += size;
  };
  for (const TriangleVertex& vertex : vertices_) {
    for (int axis = 0; axis < 3; ++axis) put(vertex.place[axis], wide_ ? 4 : 2);
  }
  for (const TriangleVertex& vertex : vertices_) put(vertex.attributes, sizeof(vertex.attributes));
  const auto width = static_cast<std::size_t>(TriangleListView::corner_bytes(vertices()));
  for (const auto& corners : corners_) {
    for (const std::uint32_t corner : corners) put(corner, width);
  }
  return bytes;
}

Status check_triangles(std::uint32_t vertices, std::uint32_t triangles, bool wide,
                       std::span<const std::byte> bytes) {
  if (bytes.size() != TriangleListView::size(vertices, triangles, wide)) {
    return Error{"surface brick: its triangles have another size"};
  }
  const TriangleListView view{bytes.data(), vertices, triangles, wide};
  for (std::uint32_t triangle = 0; triangle < triangles; ++triangle) {
    for (int corner = 0; corner < 3; ++corner) {
      if (view.vertex(triangle, corner) >= vertices) {
        return Error{"surface brick: triangle " + std::to_string(triangle) +
                     " has a vertex that is not there"};
      }
    }
  }
  return {};
}

}  // namespace gvx::surface
