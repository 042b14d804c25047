#include "gvx/surface/primary_grid.h"

#include <random>

#include <gtest/gtest.h>

namespace gvx::surface {
namespace {

using Columns = std::array<std::uint32_t, kCells * kCells>;

/// Of `share` of the columns, with one cell or, of some of them, a few.
Columns random_columns(std::mt19937& random, double share, double many) {
  Columns columns{};
  std::uniform_real_distribution<double> unit(0, 1);
  for (std::uint32_t& column : columns) {
    if (unit(random) >= share) continue;
    column = 1u << random() % 32;
    if (unit(random) < many) column |= static_cast<std::uint32_t>(random() & random() & random());
    if (unit(random) < 0.1 * many) column = ~0u;
  }
  return columns;
}

/// Each of so many ranks is that of one cell.
void expect_ranks(const PrimaryGridView& grid, std::size_t samples) {
  std::vector<int> found(samples);
  for (int v = 0; v < kCells; ++v) {
    for (int u = 0; u < kCells; ++u) {
      for (std::uint32_t bits = grid.column(u, v); bits != 0; bits &= bits - 1) {
        ++found.at(grid.rank(u, v, lowest_bit(bits)));
      }
    }
  }
  for (const int times : found) ASSERT_EQ(times, 1);
}

TEST(PrimaryGrid, forms_hold_the_same_cells_and_rank_each_once) {
  std::mt19937 random(1);
  for (const double share : {0.0, 0.02, 0.4, 1.0}) {
    for (const double many : {0.0, 0.1, 1.0}) {
      const Columns columns = random_columns(random, share, many);
      std::size_t cells = 0;
      for (const std::uint32_t column : columns) cells += static_cast<std::size_t>(bits_in(column));
      for (const GridForm form : {GridForm::heights, GridForm::masks}) {
        const PrimaryGrid grid = make_grid(columns, form);
        const PrimaryGridView view = grid.view();
        for (int v = 0; v < kCells; ++v) {
          for (int u = 0; u < kCells; ++u) {
            ASSERT_EQ(view.column(u, v), columns[static_cast<std::size_t>(column_at(u, v))]);
          }
        }
        expect_ranks(view, cells);
        ASSERT_EQ(check_grid(form, grid.bytes).value(), cells);
      }
    }
  }
}

TEST(PrimaryGrid, takes_the_form_that_is_smaller) {
  std::mt19937 random(2);
  EXPECT_EQ(make_grid(random_columns(random, 0.5, 0.05)).form, GridForm::heights);
  EXPECT_EQ(make_grid(random_columns(random, 1, 1)).form, GridForm::masks);
}

TEST(PrimaryGrid, damaged_bytes_are_errors) {
  std::mt19937 random(3);
  for (const GridForm form : {GridForm::heights, GridForm::masks}) {
    const std::vector<std::byte> whole = make_grid(random_columns(random, 0.5, 0.5), form).bytes;
    for (std::size_t cut = 0; cut < whole.size(); cut += 7) {
      EXPECT_FALSE(check_grid(form, std::span(whole).first(cut)).ok()) << cut;
    }
    int refused = 0;
    for (int trial = 0; trial < 3000; ++trial) {
      std::vector<std::byte> bytes = whole;
      bytes[random() % bytes.size()] ^= static_cast<std::byte>(1u << random() % 8);
      const auto checked = check_grid(form, bytes);
      refused += checked.ok() ? 0 : 1;
      // What is not refused holds other cells, but is as sound.
      if (checked.ok()) expect_ranks(PrimaryGridView{bytes.data(), form}, checked.value());
    }
    EXPECT_GT(refused, 1000);
  }
}

}  // namespace
}  // namespace gvx::surface
