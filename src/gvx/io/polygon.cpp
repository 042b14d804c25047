#include "gvx/io/polygon.h"

#include <algorithm>
#include <cmath>

namespace gvx::io {
namespace {

/// Corners that turn by less than this, in radians, are straight.
constexpr double kStraight = 1e-12;
/// Looks at corners before the rest is cut without looking: a second or so.
constexpr std::int64_t kMostLooks = 100'000'000;

/// Twice the area and its direction (Newell's method).
Vec3d area_of(std::span<const Vec3d> corners) {
  Vec3d sum;
  for (std::size_t i = 2; i < corners.size(); ++i) {
    sum = sum + cross(corners[i - 1] - corners[0], corners[i] - corners[0]);
  }
  return sum;
}

bool sees_all(std::span<const Vec3d> corners, Vec3d normal) {
  for (std::size_t i = 2; i < corners.size(); ++i) {
    const Vec3d a = corners[i - 1] - corners[0], b = corners[i] - corners[0];
    if (!(dot(cross(a, b), normal) > kStraight * length(a) * length(b))) return false;
  }
  return true;
}

struct Point {
  double u, v;
  bool operator==(const Point&) const = default;
};

/// Above 0 where a, b, c turn left.
double turn(Point a, Point b, Point c) {
  return (b.u - a.u) * (c.v - b.v) - (b.v - a.v) * (c.u - b.u);
}

bool turns_left(Point a, Point b, Point c) {
  return turn(a, b, c) > kStraight * std::hypot(b.u - a.u, b.v - a.v) * std::hypot(c.u - b.u, c.v - b.v);
}

/// Clips ears off a polygon that goes round to the left.
class EarClipper {
 public:
  explicit EarClipper(std::vector<Point> points)
      : points_(std::move(points)),
        before_(points_.size()),
        after_(points_.size()),
        there_(points_.size(), true) {
    const auto count = static_cast<std::uint32_t>(points_.size());
    for (std::uint32_t i = 0; i < count; ++i) {
      before_[i] = (i + count - 1) % count;
      after_[i] = (i + 1) % count;
    }
    for (std::uint32_t i = 0; i < count; ++i) {
      if (!turns_left(points_[before_[i]], points_[i], points_[after_[i]])) blocking_.push_back(i);
    }
    std::sort(blocking_.begin(), blocking_.end(),
              [&](std::uint32_t a, std::uint32_t b) { return points_[a].u < points_[b].u; });
  }

  void cut(std::vector<std::array<std::uint32_t, 3>>& triangles) {
    auto left = points_.size();
    std::uint32_t i = 0;
    std::size_t refused = 0;
    Demand demand = Demand::clear;
    while (left > 3) {
      --looks_left_;
      if (is_ear(i, looks_left_ > 0 ? demand : Demand::nothing)) {
        triangles.push_back({before_[i], i, after_[i]});
        there_[i] = false;
        after_[before_[i]] = after_[i];
        before_[after_[i]] = before_[i];
        // Not the next one: ears that follow each other would make a fan of thin triangles.
        i = after_[after_[i]];
        --left;
        refused = 0;
        demand = Demand::clear;
      } else {
        i = after_[i];
        if (++refused == left) {
          refused = 0;
          demand = static_cast<Demand>(static_cast<int>(demand) + 1);
        }
      }
    }
    triangles.push_back({before_[i], i, after_[i]});
  }

 private:
  /// Of an ear, ever less where a polygon has none: that no corner touches it; that none is in it; that it
  /// turns the right way.
  enum class Demand { clear, empty, left, nothing };

  bool is_ear(std::uint32_t i, Demand demand) {
    if (demand == Demand::nothing) return true;
    const Point a = points_[before_[i]], b = points_[i], c = points_[after_[i]];
    if (!turns_left(a, b, c)) return false;
    if (demand == Demand::left) return true;
    const auto [low, high] = std::minmax({a.u, b.u, c.u});
    auto other = std::lower_bound(blocking_.begin(), blocking_.end(), low,
                                  [&](std::uint32_t k, double u) { return points_[k].u < u; });
    for (; other != blocking_.end() && points_[*other].u <= high; ++other) {
      --looks_left_;
      const Point p = points_[*other];
      if (!there_[*other] || p == a || p == b || p == c) continue;
      const double least = std::min({turn(a, b, p), turn(b, c, p), turn(c, a, p)});
      if (demand == Demand::clear ? least >= 0 : least > 0) return false;
    }
    return true;
  }

  std::vector<Point> points_;
  std::vector<std::uint32_t> before_, after_;
  std::vector<bool> there_;
  std::vector<std::uint32_t> blocking_;  // corners that an ear may hold, by u
  std::int64_t looks_left_ = kMostLooks;
};

}  // namespace

void cut_polygon(std::span<const Vec3d> corners, std::vector<std::array<std::uint32_t, 3>>& triangles) {
  if (corners.size() < 3) return;
  const Vec3d area = area_of(corners);
  const double size = length(area);
  const bool flat = !(size > 0 && std::isfinite(size));
  if (corners.size() == 3 || flat || sees_all(corners, area / size)) {
    for (std::uint32_t i = 2; i < corners.size(); ++i) triangles.push_back({0, i - 1, i});
    return;
  }
  // Seen along the axis that the polygon faces most, so that it goes round to the left.
  int axis = 0;
  for (const int other : {1, 2}) {
    if (std::fabs(area[other]) > std::fabs(area[axis])) axis = other;
  }
  int u = (axis + 1) % 3, v = (axis + 2) % 3;
  if (area[axis] < 0) std::swap(u, v);
  std::vector<Point> points;
  points.reserve(corners.size());
  for (const Vec3d& p : corners) points.push_back({p[u] - corners[0][u], p[v] - corners[0][v]});
  EarClipper(std::move(points)).cut(triangles);
}

}  // namespace gvx::io
