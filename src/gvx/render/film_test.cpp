#include "gvx/render/film.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace gvx::render {
namespace {

TEST(Film, shows_finished_rays_then_the_finest_preview_then_the_background) {
  Film film(exec::Device::cpu(), 5, 3);
  film.preview()[0] = {{0.25f, 0, 0}, 0.5f, 3, 2, 1, 1, 1};  // stands for the whole block
  film.preview()[2] = {{0, 0.5f, 0}, 0.5f, 1, 1, 0, 1, 1};   // of block 2: pixels (2..3, 0..1)
  film.rays()[3] = {7, {0, 0, 1}, 1, RayPhase::finished, 11, 1};
  const Picture picture = film.develop(1, {0, 0, 0.5f}, true);
  const auto pixel = [&](int x, int y) {
    return Vec3f(picture.rgba[4 * (5 * y + x)], picture.rgba[4 * (5 * y + x) + 1],
                 picture.rgba[4 * (5 * y + x) + 2]);
  };
  EXPECT_EQ(pixel(0, 0), Vec3f(0.25f, 0, 0.25f));
  EXPECT_EQ(pixel(4, 2), Vec3f(0.25f, 0, 0.25f));
  EXPECT_EQ(pixel(2, 1), Vec3f(0, 0.5f, 0.25f));
  EXPECT_EQ(pixel(3, 0), Vec3f(0, 0, 1));
  const FilmTotals totals = film.totals();
  EXPECT_EQ(totals.samples, 11u);
  EXPECT_EQ(totals.unfinished, 14u);
  EXPECT_EQ(totals.wanted, 4u);
  EXPECT_EQ(totals.resident, 3u);
  EXPECT_EQ(totals.worst_lack, 1u);
  film.preview()[0].generation = 2;  // newer data, if in a larger block
  EXPECT_EQ(film.develop(1, {0, 0, 0.5f}, true).rgba[4 * (5 * 1 + 2)], 0.25f);
  film.clear();
  EXPECT_EQ(film.totals().unfinished, 15u);
  EXPECT_EQ(film.develop(1, {0, 0, 0.5f}, true).rgba[4 * 3 + 2], 0.5f);
}

TEST(Film, shows_nothing_in_blank_tiles_whatever_was_there) {
  Film film(exec::Device::cpu(), 100, 10);
  for (RayState& ray : film.rays()) ray = {1, {1, 0, 0}, 1, RayPhase::finished, 2, 1};
  film.clear();
  film.preview()[70] = {{0, 1, 0}, 1, 1, 1, 0, 2, 1};
  film.blank_tiles()[1] = 2;
  const Picture picture = film.develop(1, {0, 0, 0.5f}, true);
  EXPECT_EQ(picture.rgba[4 * 70], 0);
  EXPECT_EQ(picture.rgba[4 * 70 + 1], 0);
  EXPECT_EQ(picture.rgba[4 * 70 + 2], 0.5f);
  EXPECT_EQ(film.totals().unfinished, 64u * 10);
  EXPECT_EQ(film.totals().samples, 0u);
  film.clear();
  EXPECT_EQ(film.totals().unfinished, 1000u);
}

TEST(Picture, keeps_alpha_apart_for_png_and_multiplied_and_linear_for_exr) {
  Film film(exec::Device::cpu(), 1, 1);
  film.rays()[0] = {0, {0.25f, 0.5f, 0}, 0.5f, RayPhase::finished, 0, 1};
  const Picture picture = film.develop(1, {}, false);
  EXPECT_EQ(picture.to_8_bit(), (std::vector<std::uint8_t>{128, 255, 0, 128}));
  const auto linear = picture.to_linear_premultiplied();
  EXPECT_NEAR(linear[0], 0.2140f * 0.5f, 1e-4f);
  EXPECT_NEAR(linear[1], 0.5f, 1e-6f);
  EXPECT_EQ(linear[3], 0.5f);
}

TEST(Psnr, is_of_what_is_seen_and_takes_no_number_for_right) {
  Picture a{1, 1, {0.5f, 0.5f, 0.5f, 1}}, b = a;
  EXPECT_EQ(psnr(a, b), std::numeric_limits<double>::infinity());
  b.rgba[0] = 0.6f;
  EXPECT_NEAR(psnr(a, b), -10 * std::log10(0.01 / 3), 1e-4);
  b.rgba[0] = NAN;
  EXPECT_EQ(psnr(a, b), 0);
}

}  // namespace
}  // namespace gvx::render
