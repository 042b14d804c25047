/// \file
/// TriangleListView: the triangles that a surface brick meets, whole: what lies beyond the brick is not cut
/// off, so that no crack can open between bricks that are drawn in different ways.
///
///     places       of each vertex three numbers of 2 bytes, or of 4 where a triangle is large:
///                  parts of a cell, kCellParts of which are one, from the brick's corner on
///     attributes   of each vertex, 6 bytes
///     corners      of each triangle the numbers of three vertices: 1 byte each where there are at
///                  most 256 vertices, else 2 where there are at most 65536, else 4
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <unordered_map>
#include <vector>

#include "gvx/core/macros.h"
#include "gvx/core/result.h"
#include "gvx/core/vec.h"
#include "gvx/surface/sample_attributes.h"

namespace gvx::surface {

/// Places of triangles' corners are rounded to this part of a cell.
inline constexpr int kCellParts = 512;

struct TriangleListView {
  const std::byte* bytes = nullptr;
  std::uint32_t vertices = 0, triangles = 0;
  bool wide = false;  ///< places are numbers of 32 bits

  GVX_HD static int corner_bytes(std::uint32_t vertices) {
    return vertices <= 1u << 8 ? 1 : vertices <= 1u << 16 ? 2 : 4;
  }
  GVX_HD static std::size_t place_bytes(bool wide) { return wide ? 12 : 6; }
  /// Of a whole list.
  GVX_HD static std::uint64_t size(std::uint64_t vertices, std::uint64_t triangles, bool wide) {
    const auto corner = static_cast<std::uint64_t>(corner_bytes(static_cast<std::uint32_t>(vertices)));
    return vertices * (place_bytes(wide) + sizeof(SampleAttributes)) + triangles * 3 * corner;
  }

  /// In parts of a cell.
  GVX_HD Vec3<std::int32_t> place(std::uint32_t vertex) const {
    Vec3<std::int32_t> place;
    if (wide) {
      std::memcpy(&place, bytes + std::size_t{vertex} * 12, 12);
    } else {
      std::int16_t parts[3];
      std::memcpy(parts, bytes + std::size_t{vertex} * 6, 6);
      place = {parts[0], parts[1], parts[2]};
    }
    return place;
  }
  GVX_HD SampleAttributes attributes(std::uint32_t vertex) const {
    SampleAttributes attributes;
    const std::size_t first = vertices * place_bytes(wide);
    std::memcpy(&attributes, bytes + first + vertex * sizeof(attributes), sizeof(attributes));
    return attributes;
  }
  /// The vertex of a corner, 0 to 2.
  GVX_HD std::uint32_t vertex(std::uint32_t triangle, int corner) const {
    const std::size_t first = vertices * (place_bytes(wide) + sizeof(SampleAttributes));
    const int width = corner_bytes(vertices);
    std::uint32_t number = 0;
    std::memcpy(&number,
                bytes + first + (std::size_t{triangle} * 3 + std::size_t(corner)) * std::size_t(width),
                static_cast<std::size_t>(width));
    return number;
  }
};

/// A corner of a triangle.
struct TriangleVertex {
  Vec3<std::int32_t> place;
  SampleAttributes attributes;

  constexpr bool operator==(const TriangleVertex&) const = default;
};

/// Gathers the triangles of a brick; corners that are alike become one vertex.
class TriangleList {
 public:
  void add(const std::array<TriangleVertex, 3>& triangle);

  std::uint32_t vertices() const { return static_cast<std::uint32_t>(vertices_.size()); }
  std::uint32_t triangles() const { return static_cast<std::uint32_t>(corners_.size()); }
  bool wide() const { return wide_; }
  /// Calls function(corners) for each triangle.
  template <typename Function>
  void for_each(const Function& function) const {
    for (const auto& corners : corners_) {
      function(
          std::array<TriangleVertex, 3>{vertices_[corners[0]], vertices_[corners[1]], vertices_[corners[2]]});
    }
  }
  std::vector<std::byte> bytes() const;

 private:
  struct Hash {
    std::size_t operator()(const TriangleVertex& vertex) const;
  };

  std::unordered_map<TriangleVertex, std::uint32_t, Hash> number_of_;
  std::vector<TriangleVertex> vertices_;
  std::vector<std::array<std::uint32_t, 3>> corners_;
  bool wide_ = false;
};

/// An error where bytes, which may be of a damaged file, are no list of so many vertices and triangles.
Status check_triangles(std::uint32_t vertices, std::uint32_t triangles, bool wide,
                       std::span<const std::byte> bytes);

}  // namespace gvx::surface
