#include "gvx/core/vec.h"

#include <gtest/gtest.h>

#include "gvx/core/affine.h"
#include "gvx/core/ray.h"

namespace gvx {
namespace {

TEST(Affine3, inverse_undoes) {
  const Affine3 a{{{2, 0.5, 0}, {0, 3, 1}, {0.25, 0, -1}}, {4, 5, 6}};
  const Vec3d p{0.3, -7, 2};
  EXPECT_LT(length(inverse(a).point(a.point(p)) - p), 1e-12);
  EXPECT_LT(length((inverse(a) * a).point(p) - p), 1e-12);
}

TEST(Affine3, transposed_vector_is_the_adjoint) {
  const Affine3 a{{{2, 0.5, 0}, {0, 3, 1}, {0.25, 0, -1}}, {4, 5, 6}};
  const Vec3d u{1, 2, 3}, v{-4, 0.5, 2};
  EXPECT_DOUBLE_EQ(dot(a.vector(u), v), dot(u, a.transposed_vector(v)));
}

TEST(Ray, crosses_the_box_it_meets) {
  const Box3d unit{{0, 0, 0}, {1, 1, 1}};
  const RayInterval hit = intersect(Ray{{-1, 0.5, 0.5}, {2, 0, 0}}, unit, 0, 100);
  EXPECT_DOUBLE_EQ(hit.enter, 0.5);
  EXPECT_DOUBLE_EQ(hit.exit, 1.0);
  EXPECT_TRUE(intersect(Ray{{-1, 2, 0.5}, {1, 0, 0}}, unit, 0, 100).empty());
  EXPECT_TRUE(intersect(Ray{{2, 0.5, 0.5}, {1, 0, 0}}, unit, 0, 100).empty());
  EXPECT_DOUBLE_EQ(intersect(Ray{{0.5, 0.5, 0.5}, {0, 0, -1}}, unit, 0, 100).exit, 0.5);
}

}  // namespace
}  // namespace gvx
