/// \file
/// Voxels: their type, what their numbers mean, ranges of their values, and the bytes of a brick, a cube of
/// m^3 voxels.
///
/// A voxel consists of one or more numbers of the same type. Each of these numbers is in an array of its own,
/// a *plane*. A brick in memory, and before compression in a store, is:
///
///     plane 0: (m+4)^3 numbers, x fastest | plane 1 ... | deviations of plane 0 | deviations of plane 1 ...
///
/// *Deviations* (only of scalars) say how much the finest voxels below a coarse voxel differ from their mean.
/// They are standard deviations, at half the resolution, with a border of one. In the finest bricks they are
/// 0.
///
///     float unit | (m/2+2)^3 bytes c, x fastest; the deviation is unit * deviation_of_code(c)
///
/// Codes are small floating-point numbers, and units are powers of two. So neighbouring bricks round equal
/// deviations to equal numbers, or nearly so, and no seam is visible between them.
#pragma once

#include <cstddef>
#include <cstdint>

#include "gvx/core/macros.h"

namespace gvx {

/// The type of a voxel's numbers. The values are those in the .gvx file.
enum class VoxelType : std::uint32_t { u8 = 1, u16 = 2, f32 = 3 };

inline std::size_t voxel_bytes(VoxelType type) {
  return type == VoxelType::u8 ? 1 : type == VoxelType::u16 ? 2 : 4;
}

inline const char* voxel_name(VoxelType type) {
  return type == VoxelType::u8 ? "u8" : type == VoxelType::u16 ? "u16" : "f32";
}

/// Calls function(T{}), where T is the C++ type for this voxel type.
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

/// A range of stored values, from the least to the greatest.
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

/// What the planes of a voxel mean. The values are those in the .gvx file.
enum class VoxelContent : std::uint32_t {
  scalar = 0,       ///< one to four channels, each with a transfer function of its own
  labels = 1,       ///< one number that names a class; never averaged, never blended
  color = 2,        ///< displayed red, green, blue times opacity; opacity of matter one voxel thick
  color_normal = 3  ///< as color; then a unit normal times opacity, where -1 to 1 are stored as 0 to 254
};

/// The most channels of a scalar volume.
inline constexpr std::uint32_t kMaxChannels = 4;

struct VoxelFormat {
  VoxelType type = VoxelType::u8;
  VoxelContent content = VoxelContent::scalar;
  std::uint32_t planes = 1;

  /// How many value ranges a node has: scalars one for each channel, others one.
  GVX_HD std::uint32_t channels() const { return content == VoxelContent::scalar ? planes : 1; }
  GVX_HD bool has_deviations() const { return content == VoxelContent::scalar; }
  /// Do stores and renderers support this combination?
  bool valid() const {
    switch (content) {
      case VoxelContent::scalar:
        return planes >= 1 && planes <= kMaxChannels;
      case VoxelContent::labels:
        return planes == 1 && type != VoxelType::f32;
      case VoxelContent::color:
        return planes == 4 && type == VoxelType::u8;
      case VoxelContent::color_normal:
        return planes == 7 && type == VoxelType::u8;
    }
    return false;
  }
  constexpr bool operator==(const VoxelFormat&) const = default;
};

inline const char* content_name(VoxelContent content) {
  constexpr const char* kNames[] = {"scalar", "labels", "color", "color+normal"};
  return kNames[static_cast<std::uint32_t>(content)];
}

/// Width of the border of a brick in memory, in voxels on each side. Trilinear samples need one voxel. Two
/// are needed by a cubic B-spline, which takes four texels along each axis.
inline constexpr int kBrickBorder = 2;

/// Numbers of one plane of a brick with this border.
GVX_HD constexpr std::size_t plane_texels(std::size_t m, std::size_t border = kBrickBorder) {
  const std::size_t edge = m + 2 * border;
  return edge * edge * edge;
}
/// The deviation of a code, in units: 0, or a number of four bits of exponent and four of mantissa.
GVX_HD constexpr float deviation_of_code(std::uint32_t code) {
  return code == 0 ? 0.0f : static_cast<float>((16 + (code & 15)) << (code >> 4)) * (1.0f / 16);
}

/// Bytes of the deviations of one plane.
GVX_HD constexpr std::size_t deviation_bytes(std::size_t m) {
  return sizeof(float) + plane_texels(m / 2, 1);
}
/// Bytes of a brick.
inline std::size_t brick_bytes(VoxelFormat format, std::size_t m, std::size_t border = kBrickBorder) {
  return format.planes * (plane_texels(m, border) * voxel_bytes(format.type) +
                          (format.has_deviations() ? deviation_bytes(m) : 0));
}

/// The value ranges of a node's channels. Unused channels have the range 0 to 0.
struct ChannelRanges {
  ValueRange channel[kMaxChannels];

  ChannelRanges() = default;
  /// For a single channel.
  GVX_HD ChannelRanges(ValueRange range) { channel[0] = range; }  // NOLINT(google-explicit-constructor)

  GVX_HD bool constant() const {
    bool all = true;
    for (const ValueRange& range : channel) all = all && range.constant();
    return all;
  }
  GVX_HD void include(const ChannelRanges& other) {
    for (std::uint32_t c = 0; c < kMaxChannels; ++c) channel[c].include(other.channel[c]);
  }
  GVX_HD bool contains(const ChannelRanges& other) const {
    bool all = true;
    for (std::uint32_t c = 0; c < kMaxChannels; ++c) {
      all = all && channel[c].minimum <= other.channel[c].minimum &&
            other.channel[c].maximum <= channel[c].maximum;
    }
    return all;
  }
  /// Each channel reduced to its minimum. For a constant node: its values.
  GVX_HD ChannelRanges at_minimum() const {
    ChannelRanges result;
    for (std::uint32_t c = 0; c < kMaxChannels; ++c)
      result.channel[c] = {channel[c].minimum, channel[c].minimum};
    return result;
  }
  constexpr bool operator==(const ChannelRanges&) const = default;
};

}  // namespace gvx
