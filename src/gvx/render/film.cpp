#include "gvx/render/film.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gvx::render {
namespace {

/// IEC 61966-2-1.
float to_linear(float display) {
  return display <= 0.04045f ? display / 12.92f : std::pow((display + 0.055f) / 1.055f, 2.4f);
}

}  // namespace

std::vector<std::uint8_t> Picture::to_8_bit() const {
  std::vector<std::uint8_t> bytes(rgba.size());
  std::transform(rgba.begin(), rgba.end(), bytes.begin(), [](float v) {
    return static_cast<std::uint8_t>(std::lround(std::clamp(v, 0.0f, 1.0f) * 255.0f));
  });
  return bytes;
}

std::vector<float> Picture::to_linear_premultiplied() const {
  std::vector<float> linear(rgba.size());
  for (std::size_t i = 0; i < rgba.size(); i += 4) {
    for (std::size_t c = 0; c < 3; ++c) linear[i + c] = to_linear(rgba[i + c]) * rgba[i + 3];
    linear[i + 3] = rgba[i + 3];
  }
  return linear;
}

double psnr(const Picture& a, const Picture& b) {
  GVX_CHECK(a.width == b.width && a.height == b.height);
  double sum = 0;
  for (std::size_t i = 0; i < a.rgba.size(); ++i) {
    if (i % 4 == 3) continue;
    const double d = std::clamp(double(a.rgba[i]), 0.0, 1.0) - std::clamp(double(b.rgba[i]), 0.0, 1.0);
    sum += d * d;
  }
  const double mean = sum / (static_cast<double>(a.rgba.size()) * 3 / 4);
  if (std::isnan(mean)) return 0;  // a pixel that is no number is as wrong as can be
  return mean > 0 ? -10 * std::log10(mean) : std::numeric_limits<double>::infinity();
}

Film::Film(const exec::Device& device, std::uint32_t width, std::uint32_t height)
    : width_(width),
      height_(height),
      rays_(device, std::size_t(width) * height),
      preview_(device, std::size_t(width) * height),
      blank_tiles_(device, grid().tiles()) {}

Film::Seen Film::seen(std::uint32_t x, std::uint32_t y) const {
  if (is_blank(x, y)) return {};
  const RayState& ray = rays_.view()[std::size_t(y) * width_ + x];
  if (ray.epoch == epoch_ && ray.phase == RayPhase::finished) return {ray.color, ray.opacity};
  Seen best;
  std::uint32_t newest = 0;
  for (std::uint32_t block = 1; block <= kLargestBlock; block *= 2) {
    const PreviewPixel& p = preview_.view()[std::size_t(y / block * block) * width_ + x / block * block];
    if (p.epoch != epoch_ || p.generation <= newest) continue;
    newest = p.generation;
    best = {p.color, p.opacity};
  }
  return best;
}

Picture Film::develop(std::uint32_t rays_per_axis, Vec3f background, bool opaque_background) const {
  const std::uint32_t k = rays_per_axis;
  Picture picture{width_ / k, height_ / k, std::vector<float>(std::size_t(width_ / k) * (height_ / k) * 4)};
  float* out = picture.rgba.data();
  for (std::uint32_t y = 0; y < picture.height; ++y) {
    for (std::uint32_t x = 0; x < picture.width; ++x, out += 4) {
      Vec3f color;
      float opacity = 0;
      for (std::uint32_t j = 0; j < k; ++j) {
        for (std::uint32_t i = 0; i < k; ++i) {
          const Seen one = seen(x * k + i, y * k + j);
          color = color + one.color;
          opacity += one.opacity;
        }
      }
      color = color / static_cast<float>(k * k);
      opacity /= static_cast<float>(k * k);
      if (opaque_background) {
        color = color + (1 - opacity) * background;
        opacity = 1;
      } else if (opacity > 0) {
        color = color / opacity;
      }
      out[0] = color.x;
      out[1] = color.y;
      out[2] = color.z;
      out[3] = opacity;
    }
  }
  return picture;
}

FilmTotals Film::totals() const {
  FilmTotals totals;
  for (std::uint32_t y = 0; y < height_; ++y) {
    for (std::uint32_t x = 0; x < width_; ++x) {
      const RayState& ray = rays_.view()[std::size_t(y) * width_ + x];
      if (ray.epoch == epoch_) totals.samples += ray.samples;
      const bool finished = ray.epoch == epoch_ && ray.phase == RayPhase::finished;
      totals.unfinished += finished || is_blank(x, y) ? 0 : 1;
    }
  }
  for (const PreviewPixel& pixel : preview_.view()) {
    if (pixel.epoch != epoch_) continue;
    totals.wanted += pixel.wanted;
    totals.resident += pixel.resident;
    totals.worst_lack = std::max(totals.worst_lack, pixel.worst_lack);
  }
  return totals;
}

double Film::resident_share(std::uint32_t block) const {
  std::uint64_t wanted = 0, resident = 0;
  for (std::uint32_t y = 0; y < height_; y += block) {
    for (std::uint32_t x = 0; x < width_; x += block) {
      const PreviewPixel& pixel = preview_.view()[std::size_t(y) * width_ + x];
      if (pixel.epoch != epoch_) continue;
      wanted += pixel.wanted;
      resident += pixel.resident;
    }
  }
  return wanted > 0 ? static_cast<double>(resident) / static_cast<double>(wanted) : 1;
}

}  // namespace gvx::render
