#include "gvx/scene/transfer_presets.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "gvx/scene/fitted_presets.h"

namespace gvx::scene {
namespace {

constexpr std::array<const char*, 13> kNames = {"ct-bone", "ct-skin",   "ct-tissue",  "mr",   "surface",
                                                "layers",  "diverging", "microscopy", "gray", "solid",
                                                "inside",  "cloud",     "ramp"};

/// Within so much of the values' span a function rises where next to all of them are one.
constexpr double kLeastRise = 1e-3;

TransferFunction ct_bone() {
  return {
      {{150, {0.62, 0.32, 0.22}}, {350, {0.88, 0.74, 0.57}}, {900, {0.97, 0.92, 0.82}}, {2000, {1, 1, 0.97}}},
      {{140, 0}, {260, 0.25}, {500, 0.7}, {1200, 0.9}},
      0};
}

TransferFunction ct_skin() {
  return {{{-500, {0.72, 0.46, 0.36}},
           {-150, {0.87, 0.65, 0.54}},
           {150, {0.95, 0.80, 0.70}},
           {600, {1, 0.95, 0.88}}},
          {{-480, 0}, {-250, 0.35}, {0, 0.6}, {400, 0.9}},
          0};
}

TransferFunction ct_tissue() {
  return {{{-300, {0.80, 0.52, 0.40}},
           {40, {0.78, 0.30, 0.24}},
           {160, {0.86, 0.55, 0.38}},
           {350, {0.95, 0.90, 0.80}}},
          {{-350, 0}, {-180, 0.015}, {20, 0.02}, {90, 0.03}, {180, 0.12}, {400, 0.6}},
          0};
}

/// A ramp from the dark half of the voxels to the brightest thousandth.
TransferFunction gray(const ValueStatistics& s) {
  const double width = s.width();
  const double floor = s.histogram.empty() ? s.minimum + 0.15 * width : s.percentile(0.6);
  const double top = s.histogram.empty() ? s.maximum : s.percentile(0.999);
  const double low = std::min(floor, s.minimum + 0.5 * width), high = std::max(top, low + 0.05 * width);
  return {{{low, {0.45, 0.42, 0.40}}, {0.5 * (low + high), {0.85, 0.80, 0.74}}, {high, {1, 1, 1}}},
          {{low, 0}, {low + 0.25 * (high - low), 0.05}, {high, 0.6}},
          0};
}

/// Black to white and opaque, for projections.
TransferFunction ramp(const ValueStatistics& s) {
  const double low = s.histogram.empty() ? s.minimum : s.percentile(0.005);
  const double high = s.histogram.empty() ? s.maximum : s.percentile(0.9998);
  return {{{low, {0, 0, 0}}, {std::max(high, low + kLeastRise * s.width()), {1, 1, 1}}}, {{low, 1}}, 0};
}

/// What is above the middle of the values, as a surface.
TransferFunction solid(const ValueStatistics& s) {
  const double width = s.width();
  const auto at = [&](double share) { return s.minimum + share * width; };
  return {{{at(0), {0.80, 0.72, 0.60}}, {at(1), {0.95, 0.90, 0.82}}}, {{at(0.3), 0}, {at(0.6), 0.9}}, 0};
}

/// What is below the middle of the values: of distances to a surface, what it encloses.
TransferFunction inside(const ValueStatistics& s) {
  const double width = s.width(), middle = 0.5 * (s.minimum + s.maximum);
  return {{{s.minimum, {0.95, 0.90, 0.82}}, {s.maximum, {0.80, 0.72, 0.60}}},
          {{middle - 0.01 * width, 0.9}, {middle + 0.01 * width, 0}},
          0};
}

/// White haze, the denser the more opaque.
TransferFunction cloud(const ValueStatistics& s) {
  const double width = s.width();
  return {{{s.minimum, {0.93, 0.95, 1}}, {s.maximum, {1, 1, 1}}},
          {{s.minimum, 0}, {s.minimum + width, 0.035}},
          0};
}

}  // namespace

std::span<const char* const> preset_names() {
  return kNames;
}

Result<TransferFunction> preset(const std::string& name, const ValueStatistics& statistics) {
  if (name == "ct-bone") return ct_bone();
  if (name == "ct-skin") return ct_skin();
  if (name == "ct-tissue") return ct_tissue();
  if (name == "mr") return mr_function(statistics);
  if (name == "surface") return surface_function(statistics);
  if (name == "layers") return layers_function(statistics);
  if (name == "diverging") return diverging_function(statistics);
  if (name == "microscopy") return microscopy_function(statistics);
  if (name == "ramp") return ramp(statistics);
  if (name == "gray") return gray(statistics);
  if (name == "solid") return solid(statistics);
  if (name == "inside") return inside(statistics);
  if (name == "cloud") return cloud(statistics);
  std::string known;
  for (const char* n : kNames) known += std::string(known.empty() ? "" : ", ") + n;
  return Error{"transfer function: no preset '" + name + "'; there are " + known};
}

std::string suggest_preset(const ValueStatistics& s) {
  // A few voxels below zero do not make a CT of other numbers.
  const double air = s.percentile(1e-3);
  const bool hounsfield = air <= -500 && s.minimum >= -4096 && s.maximum >= 700 && s.maximum <= 32767;
  if (hounsfield && s.channels == 1) return "ct-bone";
  if (s.channels > 1) return "microscopy";
  if (is_around_zero(s)) return "diverging";
  if (s.anatomical && s.minimum >= 0) return "mr";
  if (s.histogram.empty()) return "gray";
  return has_surface(s) ? "surface" : "layers";
}

}  // namespace gvx::scene
