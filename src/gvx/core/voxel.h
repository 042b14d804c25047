/// \file
/// The voxel types that stores and brick pools hold, and the value range of a set of voxels.
#pragma once

#include <cstddef>
#include <cstdint>

#include "gvx/core/macros.h"

namespace gvx {

/// The numbers are those of the .gvx file.
enum class VoxelType : std::uint32_t { u8 = 1, u16 = 2, f32 = 3 };

inline std::size_t voxel_bytes(VoxelType type) {
  return type == VoxelType::u8 ? 1 : type == VoxelType::u16 ? 2 : 4;
}

inline const char* voxel_name(VoxelType type) {
  return type == VoxelType::u8 ? "u8" : type == VoxelType::u16 ? "u16" : "f32";
}

/// Calls function(T{}) with the C++ type of the voxel type.
template <typename Function>
decltype(auto) with_voxel_type(VoxelType type, Function&& function) {
  switch (type) {
    case VoxelType::u8:
      return function(std::uint8_t{});
    case VoxelType::u16:
      return function(std::uint16_t{});
    case VoxelType::f32:
      break;
  }
  return function(float{});
}

/// The least and the greatest of some stored values; holds everything between them.
struct ValueRange {
  float minimum = 0;
  float maximum = 0;

  GVX_HD bool constant() const { return minimum == maximum; }
  GVX_HD bool contains(float v) const { return minimum <= v && v <= maximum; }
  GVX_HD void include(ValueRange other) {
    minimum = other.minimum < minimum ? other.minimum : minimum;
    maximum = other.maximum > maximum ? other.maximum : maximum;
  }
  constexpr bool operator==(const ValueRange&) const = default;
};

}  // namespace gvx
