#include "gvx/io/tiff_page.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace gvx::io {

bool same_shape(const TiffPage& a, const TiffPage& b) {
  return a.width == b.width && a.height == b.height && a.type == b.type && a.bits == b.bits &&
         a.samples == b.samples && a.alpha_sample == b.alpha_sample && a.colors == b.colors;
}

bool is_smaller_copy(const TiffPage& page, const TiffPage& full) {
  const bool equal = page.width == full.width && page.height == full.height;
  if (equal || page.width > full.width || page.height > full.height) return false;
  // Sizes were rounded up or down to whole pixels: the factors that explain each axis are a range.
  double least = 1, greatest = std::numeric_limits<double>::infinity();
  for (const auto& [small, large] : {std::pair{page.width, full.width}, {page.height, full.height}}) {
    least = std::max(least, static_cast<double>(large) / static_cast<double>(small + 1));
    if (small > 1) greatest = std::min(greatest, static_cast<double>(large) / static_cast<double>(small - 1));
  }
  return least < greatest && greatest > 1.5;
}

std::string shape_text(const TiffPage& page) {
  return std::to_string(page.width) + " x " + std::to_string(page.height) + " pixels of " +
         (page.samples > 1 ? std::to_string(page.samples) + " " : "") +
         (page.floating && page.bits == 16 ? "f16" : sample_name(page.type));
}

}  // namespace gvx::io
