/// \file
/// Polygons in space, cut into triangles.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "gvx/core/vec.h"

namespace gvx::io {

/// Appends the triangles of a polygon to `triangles`, as indices of its corners; two less than it has
/// corners. Each side of the polygon is a side of one triangle, in the polygon's direction. Where the first
/// corner sees all of the polygon it is a fan. Others are cut by clipping ears on the polygon's plane
/// (Meisters 1975). Polygons that cross themselves are cut as well as can be; any takes a bounded time.
void cut_polygon(std::span<const Vec3d> corners, std::vector<std::array<std::uint32_t, 3>>& triangles);

}  // namespace gvx::io
