#include "gvx/io/transfer_function_file.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <vector>

#include "gvx/core/text_file.h"
#include "gvx/io/header_text.h"
#include "gvx/io/srgb.h"

namespace gvx::io {
namespace {

using nlohmann::json;

// Colours whose distance from black, or whose angle from the grey axis, is below this have no hue.
constexpr double kGrey = 1e-3;

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

/// Polar coordinates of L*a*b*: its length, the angle from the grey axis, and the hue's angle (K. Moreland,
/// "Diverging Color Maps for Scientific Visualization", 2009, section 3.2).
struct Msh {
  double m, s, h;
};

Msh to_msh(Vec3d rgb) {
  const Vec3d lab = to_lab(rgb);
  const double m = length(lab);
  if (m < kGrey) return {0, 0, 0};
  const double s = std::acos(std::clamp(lab.x / m, -1.0, 1.0));
  return {m, s, s < kGrey ? 0 : std::atan2(lab.z, lab.y)};
}

Vec3d from_msh(Msh c) {
  return from_lab(c.m * Vec3d{std::cos(c.s), std::sin(c.s) * std::cos(c.h), std::sin(c.s) * std::sin(c.h)});
}

/// The hue with which a colour goes over into one without, of length m, so that it seems to keep its own.
double hue_towards_grey(const Msh& colored, double m) {
  if (colored.m >= m - 0.1) return colored.h;
  const double spin =
      colored.s * std::sqrt(m * m - colored.m * colored.m) / (colored.m * std::sin(colored.s));
  return colored.h > -M_PI / 3 ? colored.h + spin : colored.h - spin;
}

/// Between two colours, `share` of the way: through white where their hues are far apart.
Vec3d mix_diverging(Vec3d from, Vec3d to, double share) {
  constexpr double kColored = 0.05, kWhiteLength = 88;
  Msh a = to_msh(from), b = to_msh(to);
  const double apart = std::abs(std::remainder(a.h - b.h, 2 * M_PI));
  if (a.s > kColored && b.s > kColored && apart > M_PI / 3) {
    const double white = std::max({a.m, b.m, kWhiteLength});
    if (share < 0.5) {
      b = {white, 0, 0};
      share = 2 * share;
    } else {
      a = {white, 0, 0};
      share = 2 * share - 1;
    }
  }
  if (a.s < kColored && b.s > kColored) a.h = hue_towards_grey(b, a.m);
  if (b.s < kColored && a.s > kColored) b.h = hue_towards_grey(a, b.m);
  return from_msh({a.m + share * (b.m - a.m), a.s + share * (b.s - a.s), a.h + share * (b.h - a.h)});
}

/// Hue, saturation and value (A. R. Smith, "Color Gamut Transform Pairs", 1978), each 0 to 1.
Vec3d to_hsv(Vec3d c) {
  const double most = std::max({c.x, c.y, c.z}), range = most - std::min({c.x, c.y, c.z});
  if (!(range > 0)) return {0, 0, most};
  const double sixths = most == c.x   ? (c.y - c.z) / range
                        : most == c.y ? 2 + (c.z - c.x) / range
                                      : 4 + (c.x - c.y) / range;
  return {(sixths < 0 ? sixths + 6 : sixths) / 6, range / most, most};
}

Vec3d from_hsv(Vec3d hsv) {
  const auto part = [&](double shift) {
    const double sixths = std::fmod(6 * (hsv.x - std::floor(hsv.x)) + shift, 6.0);
    return hsv.z * (1 - hsv.y * std::clamp(2 - std::abs(sixths - 3), 0.0, 1.0));
  };
  return {part(0), part(4), part(2)};
}

/// `wraps`: hues may go the shorter way, over red.
Vec3d mix_hsv(Vec3d from, Vec3d to, double share, bool wraps) {
  Vec3d a = to_hsv(from), b = to_hsv(to);
  if (wraps && std::abs(a.x - b.x) > 0.5) (a.x > b.x ? a.x : b.x) -= 1;
  return from_hsv(a + share * (b - a));
}

Vec3d mix_lab(Vec3d from, Vec3d to, double share) {
  const Vec3d a = to_lab(from);
  return from_lab(a + share * (to_lab(to) - a));
}

/// The points with as many more between them as straight lines need to be right to a quarter of a step of
/// 8 bits.
template <typename Mix>
std::vector<scene::ColorPoint> subdivided(const std::vector<scene::ColorPoint>& points, const Mix& mix) {
  constexpr double kTolerance = 0.25 / 255;
  constexpr int kMostHalvings = 10;
  std::vector<scene::ColorPoint> fine;
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const scene::ColorPoint &a = points[i], &b = points[i + 1];
    // Shares of the way and the colours there; adds what is between and the last.
    const auto add = [&](const auto& self, double from, Vec3d first, double to, Vec3d last,
                         int halvings) -> void {
      const auto is_off = [&](double part) {
        const Vec3d off = mix(a.color, b.color, from + part * (to - from)) - (first + part * (last - first));
        return std::max({std::abs(off.x), std::abs(off.y), std::abs(off.z)}) > kTolerance;
      };
      if (halvings < kMostHalvings && (is_off(0.25) || is_off(0.5) || is_off(0.75))) {
        const double middle = 0.5 * (from + to);
        const Vec3d here = mix(a.color, b.color, middle);
        self(self, from, first, middle, here, halvings + 1);
        return self(self, middle, here, to, last, halvings + 1);
      }
      fine.push_back({a.value + to * (b.value - a.value), last});
    };
    if (i == 0) fine.push_back(a);
    add(add, 0, a.color, 1, b.color, a.value < b.value ? 0 : kMostHalvings);
  }
  if (fine.empty()) return points;
  return fine;
}

/// Between two points the colour of the second.
std::vector<scene::ColorPoint> in_steps(const std::vector<scene::ColorPoint>& points) {
  std::vector<scene::ColorPoint> steps = {points.front()};
  for (std::size_t i = 1; i < points.size(); ++i) {
    steps.push_back({points[i - 1].value, points[i].color});
    steps.push_back(points[i]);
  }
  return steps;
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

/// Is a field there, and neither false nor 0?
bool is_set(const json& map, const char* field) {
  if (!map.contains(field)) return false;
  const json& value = map[field];
  return value.is_boolean() ? value.get<bool>() : value.is_number() && value.get<double>() != 0;
}

Status read_colors(const std::string& path, const json& map, scene::TransferFunction& function) {
  GVX_ASSIGN(const auto v, numbers(path, map, "RGBPoints", 4));
  for (std::size_t i = 0; i < v.size(); i += 4)
    function.colors.push_back({v[i], {v[i + 1], v[i + 2], v[i + 3]}});
  if (map.contains("ColorSpace") && !map["ColorSpace"].is_string()) {
    return file_error(path, "ColorSpace is not a name");
  }
  const std::string space = map.contains("ColorSpace") ? map["ColorSpace"] : "RGB";
  const bool wraps = is_set(map, "HSVWrap");
  if (space == "Lab" || space == "CIELAB") {
    function.colors = subdivided(function.colors, mix_lab);
  } else if (space == "Diverging") {
    function.colors = subdivided(function.colors, mix_diverging);
  } else if (space == "HSV") {
    function.colors = subdivided(function.colors,
                                 [&](Vec3d a, Vec3d b, double share) { return mix_hsv(a, b, share, wraps); });
  } else if (space == "Step") {
    function.colors = in_steps(function.colors);
  } else if (space != "RGB") {
    return file_error(path, "ColorSpace " + io::quoted(space) +
                                " is not supported; RGB, HSV, Lab, Diverging or Step expected");
  }
  return {};
}

/// A colour for each category: each annotated value has the next of the colours, from the first on again
/// where there are fewer; without annotations they are those of 0, 1, 2.. Between categories the nearest
/// counts.
Status read_categories(const std::string& path, const json& map, scene::TransferFunction& function) {
  GVX_ASSIGN(const auto v, numbers(path, map, "IndexedColors", 3));
  std::vector<Vec3d> colors;
  for (std::size_t i = 0; i < v.size(); i += 3) colors.emplace_back(v[i], v[i + 1], v[i + 2]);
  std::vector<scene::ColorPoint> categories;
  if (map.contains("Annotations") && !map["Annotations"].empty()) {
    const json& annotations = map["Annotations"];
    if (!annotations.is_array() || annotations.size() % 2 != 0) {
      return file_error(path, "Annotations is not a list of values and names in turn");
    }
    for (std::size_t i = 0; i < annotations.size(); i += 2) {
      const json& value = annotations[i];
      const std::optional<double> number = value.is_number()   ? std::optional(value.get<double>())
                                           : value.is_string() ? parse_number(value.get<std::string>())
                                                               : std::nullopt;
      if (!number) return file_error(path, "Annotations holds a value that is not a number");
      categories.push_back({*number, colors[i / 2 % colors.size()]});
    }
    std::stable_sort(categories.begin(), categories.end(),
                     [](const auto& a, const auto& b) { return a.value < b.value; });
  } else {
    for (const Vec3d& color : colors) categories.push_back({double(categories.size()), color});
  }
  function.colors = {categories.front()};
  for (std::size_t i = 1; i < categories.size(); ++i) {
    const double between = categories[i - 1].value + 0.5 * (categories[i].value - categories[i - 1].value);
    function.colors.push_back({between, categories[i - 1].color});
    function.colors.push_back({between, categories[i].color});
  }
  // As of label_colors: 0 is what is around.
  if (!map.contains("Points")) function.opacities = {{0, 0}, {0.5, 0}, {0.5, 0.9}};
  return {};
}

Status read_opacities(const std::string& path, const json& map, scene::TransferFunction& function) {
  if (!map.contains("Points")) {
    if (function.opacities.empty())
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
  GVX_ASSIGN(const std::string text, read_text_file(path, "a transfer function"));
  json document = json::parse(text, nullptr, false, true);
  if (document.is_discarded()) return file_error(path, "not JSON");
  if (document.is_array() && !document.empty()) document = document.front();
  if (!document.is_object() || !(document.contains("RGBPoints") || document.contains("IndexedColors"))) {
    return file_error(path, "not a colour map: an object with RGBPoints or IndexedColors expected");
  }
  scene::TransferFunction function;
  const bool by_category = document.contains("IndexedColors") &&
                           (!document.contains("RGBPoints") || is_set(document, "IndexedLookup"));
  if (by_category) {
    GVX_TRY(read_categories(path, document, function));
  } else {
    GVX_TRY(read_colors(path, document, function));
  }
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
