#include "metrics.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "gvx/core/result.h"

namespace gvx::bench {
namespace {

constexpr int kWindow = 11;

std::vector<double> luma(const render::Picture& picture) {
  std::vector<double> result;
  for (std::size_t i = 0; i < picture.rgba.size(); i += 4) {
    const auto part = [&](std::size_t c) { return std::clamp(double(picture.rgba[i + c]), 0.0, 1.0); };
    result.push_back(0.299 * part(0) + 0.587 * part(1) + 0.114 * part(2));
  }
  return result;
}

}  // namespace

double finite_psnr(const render::Picture& a, const render::Picture& b) {
  return std::min(render::psnr(a, b), 200.0);  // a number that JSON can hold where they are equal
}

double ssim(const render::Picture& a, const render::Picture& b) {
  GVX_CHECK(a.width == b.width && a.height == b.height && a.width >= kWindow && a.height >= kWindow);
  double weight[kWindow], all = 0;
  for (int i = 0; i < kWindow; ++i) all += weight[i] = std::exp(-(i - 5) * (i - 5) / (2 * 1.5 * 1.5));
  for (double& w : weight) w /= all;
  const std::vector<double> la = luma(a), lb = luma(b);
  double sum = 0;
  for (std::size_t y = 0; y + kWindow <= a.height; ++y) {
    for (std::size_t x = 0; x + kWindow <= a.width; ++x) {
      double mean_a = 0, mean_b = 0, aa = 0, bb = 0, ab = 0;
      for (std::size_t j = 0; j < kWindow; ++j) {
        for (std::size_t i = 0; i < kWindow; ++i) {
          const std::size_t at = (y + j) * a.width + x + i;
          const double w = weight[i] * weight[j];
          mean_a += w * la[at];
          mean_b += w * lb[at];
          aa += w * la[at] * la[at];
          bb += w * lb[at] * lb[at];
          ab += w * la[at] * lb[at];
        }
      }
      constexpr double kC1 = 0.01 * 0.01, kC2 = 0.03 * 0.03;
      const double both = mean_a * mean_b, squares = mean_a * mean_a + mean_b * mean_b;
      sum += (2 * both + kC1) * (2 * (ab - both) + kC2) / ((squares + kC1) * (aa + bb - squares + kC2));
    }
  }
  return sum / (double(a.width - kWindow + 1) * double(a.height - kWindow + 1));
}

std::vector<float> differences(const render::Picture& a, const render::Picture& b) {
  GVX_CHECK(a.width == b.width && a.height == b.height);
  std::vector<float> result;
  for (std::size_t i = 0; i < a.rgba.size(); i += 4) {
    float most = 0;
    for (std::size_t c = 0; c < 3; ++c) most = std::max(most, std::abs(a.rgba[i + c] - b.rgba[i + c]));
    result.push_back(most);
  }
  return result;
}

double percentile(std::vector<float> values, double share) {
  if (values.empty()) return 0;
  const auto rank = static_cast<std::size_t>(std::ceil(share * static_cast<double>(values.size())));
  const std::size_t at = std::clamp<std::size_t>(rank, 1, values.size()) - 1;
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(at), values.end());
  return double(values[at]);
}

RankTest rank_test(const std::vector<float>& a, const std::vector<float>& b) {
  if (a.empty() || b.empty()) return {};
  std::vector<std::pair<float, bool>> all;
  for (const float v : a) all.emplace_back(v, true);
  for (const float v : b) all.emplace_back(v, false);
  std::sort(all.begin(), all.end());
  const double na = double(a.size()), nb = double(b.size()), n = na + nb;
  double rank_sum = 0, ties = 0;
  for (std::size_t i = 0; i < all.size();) {
    std::size_t end = i, of_a = 0;
    for (; end < all.size() && all[end].first == all[i].first; ++end) of_a += all[end].second ? 1 : 0;
    const double count = double(end - i);
    rank_sum += double(of_a) * (double(i) + (count + 1) / 2);
    ties += count * count * count - count;
    i = end;
  }
  const double u = rank_sum - na * (na + 1) / 2;
  const double variance = na * nb / 12 * (n + 1 - ties / (n * (n - 1)));
  return {u / (na * nb), variance > 0 ? (u - na * nb / 2) / std::sqrt(variance) : 0};
}

}  // namespace gvx::bench
