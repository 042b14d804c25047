#include "gvx/render/frame/level_views.h"

#include <algorithm>

namespace gvx::render {
namespace {

/// A place along an axis by the node of each level that holds it, from the root down.
class Descent {
 public:
  explicit Descent(DoubleDouble place) : root_(floor(place).high), in_node_(place - floor(place)) {}

  /// The unit cube that holds the place.
  double root() const { return root_; }
  /// Where in the node of the present level it is, 0 to 1.
  DoubleDouble in_node() const { return in_node_; }
  /// Goes down a level; returns the node's place among its parent's children.
  int down(int n) {
    const DoubleDouble scaled = in_node_ * double(n);
    const int digit = std::clamp(static_cast<int>(floor(scaled).high), 0, n - 1);
    in_node_ = scaled - double(digit);
    return digit;
  }

 private:
  double root_;
  DoubleDouble in_node_;
};

/// The first 26 bits, so that products with whole numbers below 2^27 are exact.
double first_bits(double v) {
  constexpr double kSplit = double(1 << 27) + 1;  // Veltkamp
  const double scaled = kSplit * v;
  return scaled - (scaled - v);
}

std::uint64_t wrapped(double whole) {
  constexpr double kMost = 9e18;
  return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::clamp(whole, -kMost, kMost)));
}

}  // namespace

std::vector<LevelView> level_views(int n, int max_level, Vec3dd eye, const Box3d& box) {
  std::vector<LevelView> levels(static_cast<std::size_t>(max_level) + 1);
  DoubleDouble edge = 1;
  for (LevelView& level : levels) {
    level.across = (DoubleDouble(1) / edge).high;
    level.edge_high = first_bits(edge.high);
    level.edge_low = (edge - level.edge_high).high;
    edge = edge / double(n);
  }
  const double arity = n;
  for (int axis = 0; axis < 3; ++axis) {
    // What lies in a box's upper face belongs to the nodes below it.
    constexpr double kHair = 1e-30;
    Descent at(eye[axis]), low(box.minimum[axis]), high(DoubleDouble(box.maximum[axis]) - kHair);
    double first = low.root() - at.root(), last = high.root() - at.root();
    std::uint64_t node = wrapped(at.root());
    DoubleDouble edge_here = 1;
    for (std::size_t l = 0; l < levels.size(); ++l, edge_here = edge_here / arity) {
      if (l > 0) {
        const int digit = at.down(n);
        levels[l].digit[axis] = digit;
        node = node * static_cast<std::uint64_t>(n) + static_cast<std::uint64_t>(digit);
        first = first * arity + low.down(n) - digit;
        last = last * arity + high.down(n) - digit;
      }
      const DoubleDouble corner = -(at.in_node() * edge_here);
      levels[l].corner_high[axis] = corner.high;
      levels[l].corner_low[axis] = corner.low;
      levels[l].first[axis] = first;
      levels[l].last[axis] = last;
      levels[l].eye[axis] = node;
    }
  }
  return levels;
}

}  // namespace gvx::render
