// How a picture of a surface differs from the reference.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <vector>

#include "embree_peer.h"
#include "gvx/surface/draw/surface_film_view.h"

namespace gvx::bench {

struct Differences {
  std::uint64_t inside = 0;               ///< pixels that the reference hits with all eight neighbours
  std::uint64_t missed = 0;               ///< of these, where the picture shows nothing
  std::uint64_t stray = 0;                ///< pixels that are shown where the reference hits none of 3 x 3
  double depth_median = 0, depth_99 = 0;  ///< of the difference along the view, in finest cells
  double psnr = 0;                        ///< of colours, in decibels
};

/// Depths and colours are compared inside. `cell_world`: the edge of a finest cell.
Differences differences(const surface::SurfaceFilmView& film, const std::vector<PeerPixel>& reference,
                        double cell_world);

nlohmann::json to_json(const Differences& differences);

}  // namespace gvx::bench
