#include "gvx/render/tile/visible_cells.h"

#include <cmath>
#include <cstring>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "gvx/brick/brick_layout.h"
#include "gvx/render/reference/sample.h"

namespace gvx::render {
namespace {

bool has_cell(std::uint64_t cells, int x, int y, int z) {
  return (cells >> (x + kCellsAcross * (y + kCellsAcross * z)) & 1) != 0;
}

/// Wherever a value and its deviation go above a bound the cell can be seen, up to half a voxel beyond its
/// own faces; and not all can.
template <int M>
void expect_nothing_hidden(bool deviates) {
  std::mt19937 random(M);
  std::vector<std::uint8_t> plane(plane_texels(M)), deviations(deviation_bytes(M));
  for (auto& texel : plane) texel = static_cast<std::uint8_t>(random() % 256 < 8 ? 150 + random() % 100 : 20);
  const float unit = 0.25f;
  std::memcpy(deviations.data(), &unit, sizeof(unit));
  for (std::size_t i = sizeof(unit); i < deviations.size(); ++i) {
    deviations[i] = static_cast<std::uint8_t>(random() % 50 == 0 ? 100 + random() % 40 : 0);
  }
  constexpr float kBound = 140;
  const one_lane::PlainTexels texels(plane.data(), M);
  const std::uint64_t cells = visible_cells<M>(
      plane.data(), deviates ? deviations.data() : nullptr,
      [&](ValueRange values, float deviation) { return values.maximum + 2 * deviation <= kBound; });
  std::uniform_real_distribution<float> anywhere(0, M), beside(-0.5f, 0.5f);
  int seen = 0;
  for (int i = 0; i < 200000; ++i) {
    const Vec3f p(anywhere(random), anywhere(random), anywhere(random));
    const Vec3f q = p + Vec3f(beside(random), beside(random), beside(random));
    const float deviation = deviates ? one_lane::deviation(deviations.data(), M, q) : 0;
    if (one_lane::sample(texels, M, q) + 2 * deviation <= kBound) continue;
    ++seen;
    const auto cell = [&](float x) { return std::min(static_cast<int>(x * kCellsAcross / M), 3); };
    ASSERT_TRUE(has_cell(cells, cell(p.x), cell(p.y), cell(p.z))) << p.x << " " << p.y << " " << p.z;
  }
  EXPECT_GT(seen, 100);
  if (M == 8) {
    EXPECT_NE(cells, ~std::uint64_t(0));
  }
}

TEST(VisibleCells, hold_all_values_that_can_be_seen) {
  expect_nothing_hidden<8>(false);
  expect_nothing_hidden<16>(false);
  expect_nothing_hidden<32>(false);
}

TEST(VisibleCells, pass_over_what_is_no_data) {
  constexpr int kM = 16;
  const auto cells_of = [](const std::vector<float>& plane) {
    return visible_cells<kM>(plane.data(), nullptr,
                             [](ValueRange values, float) { return values.maximum <= 0.5f; });
  };
  std::vector<float> plane(plane_texels(kM), NAN);
  EXPECT_EQ(cells_of(plane), 0u);
  // A single value, beside which there is no data: of the cell that it is in the middle of.
  plane[static_cast<std::size_t>(brick::BrickLayout<kM>::offset(7, 11, 3))] = 1;
  EXPECT_EQ(cells_of(plane), std::uint64_t(1) << (1 + 4 * (2 + 4 * 0)));
  for (std::size_t i = 0; i < plane.size(); i += 2) plane[i] = 0.25f;
  EXPECT_EQ(cells_of(plane), 0u);
  for (std::size_t i = 0; i < plane.size(); i += 2) plane[i] = 1;
  EXPECT_EQ(cells_of(plane), ~std::uint64_t(0));
}

TEST(VisibleCells, hold_all_deviations_that_can_be_seen) {
  expect_nothing_hidden<8>(true);
  expect_nothing_hidden<16>(true);
  expect_nothing_hidden<32>(true);
}

/// A child's cell has what the parent's cells have that it touches.
template <int N>
void expect_cells_of_children() {
  std::mt19937_64 random(N);
  for (int i = 0; i < 2000; ++i) {
    const std::uint64_t parent = random() & random();
    const int digit[3] = {static_cast<int>(random() % N), static_cast<int>(random() % N),
                          static_cast<int>(random() % N)};
    const std::uint64_t cells = cells_of_child<N>(parent, digit);
    for (int cell = 0; cell < kCells; ++cell) {
      const int at[3] = {cell % 4, cell / 4 % 4, cell / 16};
      bool touches = false;
      for (int above = 0; above < kCells; ++above) {
        const int of[3] = {above % 4, above / 4 % 4, above / 16};
        bool meets = true;  // in units of the child's cells, N of which are as wide as one above
        for (int axis = 0; axis < 3; ++axis) {
          const int low = digit[axis] * kCellsAcross + at[axis];
          meets = meets && low < (of[axis] + 1) * N && low + 1 > of[axis] * N;
        }
        touches = touches || (meets && has_cell(parent, of[0], of[1], of[2]));
      }
      ASSERT_EQ(has_cell(cells, at[0], at[1], at[2]), touches) << N << ": " << cell;
    }
  }
}

TEST(VisibleCells, of_a_child_are_those_that_touch_its_parents) {
  expect_cells_of_children<2>();
  expect_cells_of_children<3>();
}

}  // namespace
}  // namespace gvx::render
