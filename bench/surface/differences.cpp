#include "differences.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace gvx::bench {

Differences differences(const surface::SurfaceFilmView& film, const std::vector<PeerPixel>& reference,
                        double cell_world) {
  Differences found;
  std::vector<double> depths;
  double squares = 0;
  for (std::int64_t y = 0; y < film.height; ++y) {
    for (std::int64_t x = 0; x < film.width; ++x) {
      int hit = 0, all = 0;
      for (std::int64_t v = std::max<std::int64_t>(y - 1, 0);
           v <= std::min<std::int64_t>(y + 1, film.height - 1); ++v) {
        for (std::int64_t u = std::max<std::int64_t>(x - 1, 0);
             u <= std::min<std::int64_t>(x + 1, film.width - 1); ++u) {
          hit += reference[static_cast<std::size_t>(v * film.width + u)].hit() ? 1 : 0;
          ++all;
        }
      }
      const surface::SurfacePixel& pixel =
          film.at(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y));
      if (pixel.seen() && hit == 0) ++found.stray;
      if (hit < all) continue;
      ++found.inside;
      if (!pixel.seen()) {
        ++found.missed;
        continue;
      }
      const PeerPixel& peer = reference[static_cast<std::size_t>(y * film.width + x)];
      depths.push_back(std::fabs(double(pixel.place) - double(peer.depth)) / cell_world);
      for (int channel = 0; channel < 3; ++channel) {
        const auto shown = [&](const Vec3f& color) { return std::clamp(double(color[channel]), 0.0, 1.0); };
        const double difference = shown(pixel.color) - shown(peer.color);
        squares += difference * difference;
      }
    }
  }
  if (depths.empty()) return found;
  const auto at_share = [&](double share) {
    const auto at =
        depths.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(depths.size() - 1));
    std::nth_element(depths.begin(), at, depths.end());
    return *at;
  };
  found.depth_median = at_share(0.5);
  found.depth_99 = at_share(0.99);
  found.psnr = 10 * std::log10(3 * static_cast<double>(depths.size()) / std::max(squares, 1e-12));
  return found;
}

nlohmann::json to_json(const Differences& differences) {
  return {{"pixels_inside", differences.inside},
          {"missed", differences.missed},
          {"stray", differences.stray},
          {"depth_median_cells", differences.depth_median},
          {"depth_99_cells", differences.depth_99},
          {"psnr", differences.psnr}};
}

}  // namespace gvx::bench
