/// \file
/// How far pictures are apart.
#pragma once

#include <vector>

#include "gvx/render/frame/film.h"

namespace gvx::bench {

/// Peak signal-to-noise ratio in dB: peak 1, mean square over red, green and blue of all pixels (background
/// included), values clamped to 0..1 first. 200 where they are equal.
double finite_psnr(const render::Picture& a, const render::Picture& b);

/// Structural similarity: Wang, Bovik, Sheikh, Simoncelli, "Image quality assessment", 2004, section III.B:
/// Gaussian windows of 11x11, sigma 1.5, K1 = 0.01, K2 = 0.03, L = 1, of the luma (0.299, 0.587, 0.114); the
/// mean over all windows that lie in the picture.
double ssim(const render::Picture& a, const render::Picture& b);

/// The greatest difference of the three colours, pixel by pixel.
std::vector<float> differences(const render::Picture& a, const render::Picture& b);

/// The value that `share` of the values do not exceed.
double percentile(std::vector<float> values, double share);

/// Mann and Whitney's test of whether values of `a` tend to be greater than those of `b`.
struct RankTest {
  double chance = 0.5;  ///< that one of a is greater than one of b, ties by halves; 0.5: neither
  double z = 0;         ///< standard deviations from 0.5, were all values independent
};
RankTest rank_test(const std::vector<float>& a, const std::vector<float>& b);

}  // namespace gvx::bench
