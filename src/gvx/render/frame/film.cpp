#include "gvx/render/frame/film.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "gvx/exec/parallel.h"

namespace gvx::render {
namespace {

/// IEC 61966-2-1.
float to_linear(float display) {
  return display <= 0.04045f ? display / 12.92f : std::pow((display + 0.055f) / 1.055f, 2.4f);
}

/// From 0 to 1; what is no number is 0.
std::uint8_t to_byte(float v) {
  return static_cast<std::uint8_t>(std::fmin(std::fmax(v, 0.0f), 1.0f) * 255.0f + 0.5f);
}

/// The `length` values of row y; none where there is no memory for any.
template <typename T>
std::span<T> row_of(const PictureRows<T>& rows, std::uint32_t y, std::size_t length) {
  if (rows.values.empty()) return {};
  return rows.values.subspan(y * (rows.stride > 0 ? rows.stride : length), length);
}

template <typename T>
Status check_rows(const char* name, const PictureRows<T>& rows, std::size_t length, std::size_t height) {
  if (rows.values.empty()) return {};
  const std::size_t stride = rows.stride > 0 ? rows.stride : length;
  // The last row needs no gap behind it.
  if (stride >= length && rows.values.size() >= length &&
      (rows.values.size() - length) / stride + 1 >= height) {
    return {};
  }
  return Error{std::string("picture: ") + name + ": " + std::to_string(rows.values.size()) +
               " values with rows " + std::to_string(stride) + " apart do not hold " +
               std::to_string(height) + " rows of " + std::to_string(length)};
}

}  // namespace

Status check(const PictureTarget& target, std::uint32_t width, std::uint32_t height) {
  GVX_TRY(check_rows("rgba8", target.rgba8, std::size_t{4} * width, height));
  GVX_TRY(check_rows("rgba", target.rgba, std::size_t{4} * width, height));
  GVX_TRY(check_rows("depth", target.depth, width, height));
  return check_rows("object", target.object, width, height);
}

std::vector<std::uint8_t> Picture::to_8_bit() const {
  std::vector<std::uint8_t> bytes(rgba.size());
  std::transform(rgba.begin(), rgba.end(), bytes.begin(), to_byte);
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

Film::Film(const exec::Device& device, std::uint32_t width, std::uint32_t height, std::uint32_t projecting)
    : width_(width),
      height_(height),
      rays_(device, std::size_t(width) * height),
      preview_(device, std::size_t(width) * height),
      blank_tiles_(device, grid().tiles()),
      projecting_(projecting),
      projections_(device, projecting > 0 ? rays_.size() : 0),
      samples_(device, rays_.size() * projecting) {}

Film::Seen Film::seen(std::uint32_t x, std::uint32_t y) const {
  if (only_surfaces_ || is_blank(x, y)) return seen_of_surfaces(x, y);
  const RayState& ray = rays_.view()[std::size_t(y) * width_ + x];
  if (ray.epoch == epoch_ && ray.phase == RayPhase::finished) return {ray.color, ray.opacity};
  return seen_in_preview(x, y);
}

Film::Seen Film::seen_of_surfaces(std::uint32_t x, std::uint32_t y) const {
  if (surfaces_.empty()) return {};
  const surface::SurfacePixel pixel = surfaces_.at(x, y);
  return pixel.shaded() ? Seen{pixel.color, 1} : Seen{};
}

Film::Seen Film::seen_in_preview(std::uint32_t x, std::uint32_t y) const {
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

Film::Seen Film::mean_of(std::uint32_t rays_per_axis, std::uint32_t x, std::uint32_t y) const {
  const std::uint32_t k = rays_per_axis;
  if (k == 1) return seen(x, y);
  Seen sum;
  for (std::uint32_t j = 0; j < k; ++j) {
    for (std::uint32_t i = 0; i < k; ++i) {
      const Seen one = seen(x * k + i, y * k + j);
      sum.color = sum.color + one.color;
      sum.opacity += one.opacity;
    }
  }
  return {sum.color / static_cast<float>(k * k), sum.opacity / static_cast<float>(k * k)};
}

Picture Film::develop(const exec::Device& cpu, const Development& how) const {
  Picture picture{width_ / how.rays_per_axis, height_ / how.rays_per_axis, {}};
  picture.rgba.resize(std::size_t(picture.width) * picture.height * 4);
  develop(cpu, how, {.rgba = {picture.rgba}});
  return picture;
}

void Film::develop(const exec::Device& cpu, const Development& how, const PictureTarget& target) const {
  const std::uint32_t k = how.rays_per_axis, width = width_ / k, height = height_ / k;
  GVX_CHECK(check(target, width, height).ok());
  exec::parallel_for(cpu, height, [&](std::size_t row) {
    const auto y = static_cast<std::uint32_t>(row);
    const auto bytes = row_of(target.rgba8, y, std::size_t{4} * width);
    const auto floats = row_of(target.rgba, y, std::size_t{4} * width);
    if (bytes.empty() && floats.empty()) return;
    for (std::uint32_t x = 0; x < width; ++x) {
      const Seen pixel = mean_of(k, x, y);
      Vec3f color = pixel.color;
      float alpha = pixel.opacity;
      if (how.opaque_background) {
        color = color + (1 - alpha) * how.background;
        alpha = 1;
      } else if (alpha > 0) {
        color = color / alpha;
      }
      const float rgba[4] = {color.x, color.y, color.z, alpha};
      if (!floats.empty()) std::copy_n(rgba, 4, &floats[std::size_t{4} * x]);
      if (!bytes.empty()) std::transform(rgba, rgba + 4, &bytes[std::size_t{4} * x], to_byte);
    }
  });
}

float Film::opacity(std::uint32_t rays_per_axis, std::uint32_t x, std::uint32_t y) const {
  return mean_of(rays_per_axis, x, y).opacity;
}

FilmTotals Film::totals() const {
  FilmTotals totals;
  for (std::uint32_t y = 0; y < height_; ++y) {
    for (std::uint32_t x = 0; x < width_; ++x) {
      const RayState& ray = rays_.view()[std::size_t(y) * width_ + x];
      if (ray.epoch == epoch_) totals.samples += ray.samples;
      const bool finished = ray.epoch == epoch_ && ray.phase == RayPhase::finished;
      totals.unfinished += finished || only_surfaces_ || is_blank(x, y) ? 0 : 1;
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
