#include "gvx/render/frame/film.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace gvx::render {
namespace {

Picture developed(const Film& film, Vec3f background, bool opaque_background) {
  return film.develop(exec::Device::cpu(), {1, background, opaque_background});
}

TEST(Film, shows_finished_rays_then_the_finest_preview_then_the_background) {
  Film film(exec::Device::cpu(), 5, 3);
  film.preview()[0] = {{0.25f, 0, 0}, 0.5f, 3, 2, 1, 1, 1};  // stands for the whole block
  film.preview()[2] = {{0, 0.5f, 0}, 0.5f, 1, 1, 0, 1, 1};   // of block 2: pixels (2..3, 0..1)
  film.rays()[3] = {7, {0, 0, 1}, 1, RayPhase::finished, 11, 1};
  const Picture picture = developed(film, {0, 0, 0.5f}, true);
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
  EXPECT_EQ(developed(film, {0, 0, 0.5f}, true).rgba[4 * (5 * 1 + 2)], 0.25f);
  film.clear();
  EXPECT_EQ(film.totals().unfinished, 15u);
  EXPECT_EQ(developed(film, {0, 0, 0.5f}, true).rgba[4 * 3 + 2], 0.5f);
}

TEST(Film, shows_nothing_in_blank_tiles_whatever_was_there) {
  Film film(exec::Device::cpu(), 100, 10);
  for (RayState& ray : film.rays()) ray = {1, {1, 0, 0}, 1, RayPhase::finished, 2, 1};
  film.clear();
  film.preview()[70] = {{0, 1, 0}, 1, 1, 1, 0, 2, 1};
  film.blank_tiles()[1] = 2;
  const Picture picture = developed(film, {0, 0, 0.5f}, true);
  EXPECT_EQ(picture.rgba[4 * 70], 0);
  EXPECT_EQ(picture.rgba[4 * 70 + 1], 0);
  EXPECT_EQ(picture.rgba[4 * 70 + 2], 0.5f);
  EXPECT_EQ(film.totals().unfinished, 64u * 10);
  EXPECT_EQ(film.totals().samples, 0u);
  film.clear();
  EXPECT_EQ(film.totals().unfinished, 1000u);
}

TEST(Film, writes_into_rows_of_the_callers) {
  Film film(exec::Device::cpu(), 70, 6);
  for (std::size_t i = 0; i < film.rays().size; ++i) {
    const float part = static_cast<float>(i) / 420;
    film.rays()[i] = {1, {part * part, 0.25f, 0}, part, RayPhase::finished, 1, 1};
  }
  for (const std::uint32_t k : {1u, 2u}) {
    const std::uint32_t width = 70 / k, height = 6 / k;
    const Film::Development how{k, {0.5f, 0, 1}, k == 1};
    const Picture picture = film.develop(exec::Device::cpu(), how);
    std::vector<std::uint8_t> bytes(300 * height - 7, 9);
    std::vector<float> floats(4 * width * height);
    film.develop(exec::Device::cpu(), how, {.rgba8 = {bytes, 300}, .rgba = {floats}});
    EXPECT_EQ(floats, picture.rgba);
    const std::vector<std::uint8_t> packed = picture.to_8_bit();
    for (std::uint32_t y = 0; y < height; ++y) {
      for (std::uint32_t i = 0; i < 4 * width; ++i) {
        ASSERT_EQ(bytes[300 * y + i], packed[4 * width * y + i]) << i << " " << y;
      }
      for (std::uint32_t i = 4 * width; i < 300 && 300 * y + i < bytes.size(); ++i) {
        ASSERT_EQ(bytes[300 * y + i], 9) << "a gap was written to";
      }
    }
  }
}

TEST(PictureTarget, rows_that_do_not_fit_are_an_error) {
  std::vector<std::uint8_t> bytes(40 * 5 + 28);
  std::vector<float> depth(42);
  EXPECT_TRUE(check({.rgba8 = {bytes, 40}, .depth = {depth}}, 7, 6).ok());
  EXPECT_TRUE(check({}, 7, 6).ok());
  EXPECT_EQ(check({.rgba8 = {bytes, 40}}, 8, 6).error().message,
            "picture: rgba8: 228 values with rows 40 apart do not hold 6 rows of 32");
  EXPECT_FALSE(check({.rgba8 = {bytes, 27}}, 7, 6).ok());
  EXPECT_FALSE(check({.rgba = {}, .depth = {depth}}, 7, 7).ok());
  EXPECT_FALSE(check({.rgba8 = {bytes, SIZE_MAX}}, 7, 6).ok());
}

TEST(Picture, keeps_alpha_apart_for_png_and_multiplied_and_linear_for_exr) {
  Film film(exec::Device::cpu(), 1, 1);
  film.rays()[0] = {0, {0.25f, 0.5f, 0}, 0.5f, RayPhase::finished, 0, 1};
  const Picture picture = developed(film, {}, false);
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
