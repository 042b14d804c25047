/// \file
/// Vectors of three numbers: Vec3f and Vec3d for positions and colours, Vec3i and Vec3u for voxels and nodes.
#pragma once

#include <cmath>
#include <cstdint>

#include "gvx/core/macros.h"

namespace gvx {

template <typename T>
struct Vec3 {
  T x{}, y{}, z{};

  constexpr Vec3() = default;
  GVX_HD constexpr Vec3(T x_, T y_, T z_) : x(x_), y(y_), z(z_) {}
  GVX_HD constexpr explicit Vec3(T s) : x(s), y(s), z(s) {}
  template <typename U>
  GVX_HD constexpr explicit Vec3(const Vec3<U>& v) : x(T(v.x)), y(T(v.y)), z(T(v.z)) {}

  /// The component of axis 0, 1 or 2.
  GVX_HD constexpr T operator[](int axis) const { return axis == 0 ? x : axis == 1 ? y : z; }
  GVX_HD constexpr T& operator[](int axis) { return axis == 0 ? x : axis == 1 ? y : z; }

  constexpr bool operator==(const Vec3&) const = default;
};

using Vec3f = Vec3<float>;
using Vec3d = Vec3<double>;
using Vec3i = Vec3<std::int64_t>;
using Vec3u = Vec3<std::uint32_t>;

template <typename T>
GVX_HD constexpr Vec3<T> operator+(Vec3<T> a, Vec3<T> b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <typename T>
GVX_HD constexpr Vec3<T> operator-(Vec3<T> a, Vec3<T> b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <typename T>
GVX_HD constexpr Vec3<T> operator-(Vec3<T> a) {
  return {-a.x, -a.y, -a.z};
}
/// Component by component.
template <typename T>
GVX_HD constexpr Vec3<T> operator*(Vec3<T> a, Vec3<T> b) {
  return {a.x * b.x, a.y * b.y, a.z * b.z};
}
template <typename T>
GVX_HD constexpr Vec3<T> operator*(Vec3<T> a, T s) {
  return {a.x * s, a.y * s, a.z * s};
}
template <typename T>
GVX_HD constexpr Vec3<T> operator*(T s, Vec3<T> a) {
  return a * s;
}
/// Component by component.
template <typename T>
GVX_HD constexpr Vec3<T> operator/(Vec3<T> a, Vec3<T> b) {
  return {a.x / b.x, a.y / b.y, a.z / b.z};
}
template <typename T>
GVX_HD constexpr Vec3<T> operator/(Vec3<T> a, T s) {
  return {a.x / s, a.y / s, a.z / s};
}
template <typename T>
GVX_HD constexpr T dot(Vec3<T> a, Vec3<T> b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <typename T>
GVX_HD constexpr Vec3<T> cross(Vec3<T> a, Vec3<T> b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <typename T>
GVX_HD T length(Vec3<T> a) {
  return std::sqrt(dot(a, a));
}
/// The vector with length 1. For the zero vector: NaNs.
template <typename T>
GVX_HD Vec3<T> normalize(Vec3<T> a) {
  return a / length(a);
}
template <typename T>
GVX_HD constexpr T max_component(Vec3<T> a) {
  return a.x > a.y ? (a.x > a.z ? a.x : a.z) : (a.y > a.z ? a.y : a.z);
}
template <typename T>
GVX_HD constexpr T min_component(Vec3<T> a) {
  return a.x < a.y ? (a.x < a.z ? a.x : a.z) : (a.y < a.z ? a.y : a.z);
}

}  // namespace gvx
