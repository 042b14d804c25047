#include "gvx/io/transfer_function_file.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <vector>

#include "gvx/io/header_text.h"
#include "gvx/io/srgb.h"

namespace gvx::io {
namespace {

using nlohmann::json;

constexpr std::size_t kLargestFile = 16u << 20;
// Straight pieces that stand in for a curve of Lab between two colours.
constexpr int kLabPieces = 16;

// CIE 1976 L*a*b* under D65, through linear sRGB (IEC 61966-2-1).
constexpr Vec3d kWhite{0.95047, 1.0, 1.08883};

Vec3d to_lab(Vec3d rgb) {
  const Vec3d l{to_linear(rgb.x), to_linear(rgb.y), to_linear(rgb.z)};
  const Vec3d xyz =
      Vec3d{dot(l, {0.4124564, 0.3575761, 0.1804375}), dot(l, {0.2126729, 0.7151522, 0.0721750}),
            dot(l, {0.0193339, 0.1191920, 0.9503041})} /
      kWhite;
  const auto f = [](double t) { return t > 216.0 / 24389 ? std::cbrt(t) : (24389.0 / 27 * t + 16) / 116; };
  const double fy = f(xyz.y);
  return {116 * fy - 16, 500 * (f(xyz.x) - fy), 200 * (fy - f(xyz.z))};
}

Vec3d from_lab(Vec3d lab) {
  const double fy = (lab.x + 16) / 116;
  const auto g = [](double f) { return f * f * f > 216.0 / 24389 ? f * f * f : (116 * f - 16) * 27 / 24389; };
  const Vec3d xyz = kWhite * Vec3d{g(fy + lab.y / 500), g(fy), g(fy - lab.z / 200)};
  const Vec3d l{dot(xyz, {3.2404542, -1.5371385, -0.4985314}), dot(xyz, {-0.9692660, 1.8760108, 0.0415560}),
                dot(xyz, {0.0556434, -0.2040259, 1.0572252})};
  const auto display = [](double v) { return std::min(1.0, std::max(0.0, to_display(std::max(0.0, v)))); };
  return {display(l.x), display(l.y), display(l.z)};
}

std::vector<scene::ColorPoint> subdivide_in_lab(const std::vector<scene::ColorPoint>& points) {
  std::vector<scene::ColorPoint> fine;
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const Vec3d a = to_lab(points[i].color), b = to_lab(points[i + 1].color);
    fine.push_back(points[i]);
    for (int k = 1; k < kLabPieces; ++k) {
      const double w = double(k) / kLabPieces;
      fine.push_back(
          {points[i].value + w * (points[i + 1].value - points[i].value), from_lab(a + w * (b - a))});
    }
  }
  fine.push_back(points.back());
  return fine;
}

/// The numbers of an array whose length is a multiple of `group`.
Result<std::vector<double>> numbers(const std::string& path, const json& map, const char* field,
                                    std::size_t group) {
  const json& array = map[field];
  if (!array.is_array() || array.empty() || array.size() % group != 0) {
    return file_error(path,
                      std::string(field) + " is not a list of " + std::to_string(group) + " numbers a point");
  }
  std::vector<double> values;
  for (const json& v : array) {
    if (!v.is_number()) return file_error(path, std::string(field) + " holds something other than numbers");
    values.push_back(v.get<double>());
  }
  return values;
}

Status read_colors(const std::string& path, const json& map, scene::TransferFunction& function) {
  GVX_ASSIGN(const auto v, numbers(path, map, "RGBPoints", 4));
  for (std::size_t i = 0; i < v.size(); i += 4)
    function.colors.push_back({v[i], {v[i + 1], v[i + 2], v[i + 3]}});
  const std::string space =
      map.contains("ColorSpace") && map["ColorSpace"].is_string() ? map["ColorSpace"] : "RGB";
  if (space == "Lab" || space == "CIELAB") {
    function.colors = subdivide_in_lab(function.colors);
  } else if (space != "RGB") {
    return file_error(path, "ColorSpace " + io::quoted(space) + " is not supported; RGB or Lab expected");
  }
  return {};
}

Status read_opacities(const std::string& path, const json& map, scene::TransferFunction& function) {
  if (!map.contains("Points")) {
    function.opacities = {{function.colors.front().value, 0}, {function.colors.back().value, 1}};
    return {};
  }
  GVX_ASSIGN(const auto v, numbers(path, map, "Points", 4));
  for (std::size_t i = 0; i < v.size(); i += 4) {
    const double midpoint = v[i + 2], sharpness = v[i + 3];
    if (sharpness != 0) return file_error(path, "Points with a sharpness other than 0 are not supported");
    function.opacities.push_back({v[i], v[i + 1]});
    // ParaView's midpoint: where, between this point and the next, the mean of the two opacities is reached.
    if (midpoint != 0.5 && i + 4 < v.size()) {
      if (!(midpoint >= 0 && midpoint <= 1))
        return file_error(path, "a midpoint in Points is outside 0 to 1");
      function.opacities.push_back({v[i] + midpoint * (v[i + 4] - v[i]), 0.5 * (v[i + 1] + v[i + 5])});
    }
  }
  return {};
}

}  // namespace

Result<scene::TransferFunction> read_transfer_function(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return file_error(path, "cannot open");
  std::string text(kLargestFile + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (file.bad()) return file_error(path, "cannot read");
  text.resize(static_cast<std::size_t>(file.gcount()));
  if (text.size() > kLargestFile) return file_error(path, "larger than a transfer function can be (16 MiB)");
  json document = json::parse(text, nullptr, false, true);
  if (document.is_discarded()) return file_error(path, "not JSON");
  if (document.is_array() && !document.empty()) document = document.front();
  if (!document.is_object() || !document.contains("RGBPoints")) {
    return file_error(path, "not a colour map: an object with RGBPoints expected");
  }
  scene::TransferFunction function;
  GVX_TRY(read_colors(path, document, function));
  GVX_TRY(read_opacities(path, document, function));
  if (document.contains("UnitDistance")) {
    if (!document["UnitDistance"].is_number()) return file_error(path, "UnitDistance is not a number");
    function.unit_distance = document["UnitDistance"].get<double>();
  }
  if (const Status status = scene::check(function); !status.ok())
    return file_error(path, status.error().message);
  return function;
}

}  // namespace gvx::io
