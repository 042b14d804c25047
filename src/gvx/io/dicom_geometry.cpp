#include "gvx/io/dicom_geometry.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "gvx/io/volume_file.h"

namespace gvx::io {
namespace {

// DICOM's x grows to the patient's left and y to the back.
constexpr Vec3d kToWorld{-1, -1, 1};

std::string fixed(double number, int digits = 2) {
  std::array<char, 64> text;
  if (std::abs(number) >= 1e6) {
    std::snprintf(text.data(), text.size(), "%.4g", number);
  } else {
    std::snprintf(text.data(), text.size(), "%.*f", digits, number);
  }
  return text.data();
}

/// Are all steps whole multiples of the least, some of them more than one? Then slices are missing.
struct Gaps {
  double step = 0;
  std::size_t missing = 0;
  std::size_t first_before = 0;  // the slice behind the first gap
};

Gaps find_gaps(const std::vector<double>& steps) {
  const double least = *std::min_element(steps.begin(), steps.end());
  Gaps gaps;
  double sum = 0;
  std::size_t single = 0;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const double times = steps[i] / least;
    if (std::abs(times - std::round(times)) > 0.02 * times || times > 1000) return {};
    if (times < 1.5) {
      sum += steps[i];
      ++single;
    } else {
      if (gaps.missing == 0) gaps.first_before = i + 1;
      gaps.missing += static_cast<std::size_t>(std::round(times)) - 1;
    }
  }
  gaps.step = sum / static_cast<double>(single);
  // Where most are missing the slices were never closer.
  return 2 * single >= steps.size() && gaps.missing > 0 ? gaps : Gaps{};
}

Affine3 to_world(const DicomFrame& frame, Vec3d origin, Vec3d spacing, Vec3d step) {
  Affine3 index_to_patient;
  index_to_patient.column[0] = spacing.x * frame.row;
  index_to_patient.column[1] = spacing.y * frame.column;
  index_to_patient.column[2] = step;
  index_to_patient.origin = origin;
  return with_world_scaled(from_index_to_centre(index_to_patient), kToWorld);
}

}  // namespace

bool DicomGeometry::upright() const {
  return deviation <= kEvenWithin && tilt_degrees <= kUprightWithin;
}

DicomGeometry place_slices(const std::vector<DicomImage>& images, std::span<const DicomSlice> slices) {
  const auto frame = [&](std::size_t i) -> const DicomFrame& {
    return images[slices[i].image].frames[slices[i].frame];
  };
  const DicomImage& image = images[slices.front().image];
  const DicomFrame& first = frame(0);
  const Vec3d normal = normalize(cross(first.row, first.column));
  DicomGeometry geometry;
  geometry.anatomical = image.placed;
  for (std::size_t i = 0; i < slices.size(); ++i) {
    const Vec3d way = frame(i).position - first.position;
    geometry.places.push_back({dot(way, first.row), dot(way, first.column), dot(way, normal)});
  }
  geometry.spacing = {first.column_spacing > 0 ? first.column_spacing : 1,
                      first.row_spacing > 0 ? first.row_spacing : 1, 0};
  const std::size_t count = slices.size();
  Vec3d step = (image.slice_step > 0 ? image.slice_step : geometry.spacing.x) * normal;
  Gaps gaps;
  double least = 0, greatest = 0;
  if (count > 1) {
    step = (frame(count - 1).position - first.position) / static_cast<double>(count - 1);
    std::vector<double> steps;
    for (std::size_t i = 1; i < count; ++i) steps.push_back(geometry.places[i].z - geometry.places[i - 1].z);
    least = *std::min_element(steps.begin(), steps.end());
    greatest = *std::max_element(steps.begin(), steps.end());
    gaps = find_gaps(steps);
    if (gaps.missing > 0) step = (gaps.step / dot(step, normal)) * step;
  }
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3d even = first.position + static_cast<double>(i) * step;
    geometry.deviation = std::max(geometry.deviation, length(frame(i).position - even));
  }
  const double along = dot(step, normal);
  geometry.spacing.z = along;
  const double sideways = length(step - along * normal);
  geometry.tilt_degrees = std::atan2(sideways, along) * 180 / std::numbers::pi;
  geometry.voxel_to_world =
      image.placed ? to_world(first, first.position, geometry.spacing, step) : scaling(geometry.spacing);
  if (!image.unusable_spacing.empty()) {
    geometry.remarks.push_back(
        "PixelSpacing is not usable (expected two numbers above 0 and below 1e6, found " +
        image.unusable_spacing + "): " +
        (first.column_spacing > 0 ? "ImagerPixelSpacing is used" : "pixels are taken to be 1 mm wide"));
  }
  if (!image.placed) {
    geometry.remarks.push_back(
        count > 1
            ? "the file does not say where its slices lie: they are shown in the order of their numbers, " +
                  fixed(along) + " mm apart"
            : "the file does not say where it lies in the patient");
    return geometry;
  }
  if (first.column_spacing <= 0 && image.unusable_spacing.empty())
    geometry.remarks.push_back("no PixelSpacing: pixels are taken to be 1 mm wide");
  if (geometry.tilt_degrees > kUprightWithin) {
    geometry.remarks.push_back(
        "the slices are tilted by " + fixed(geometry.tilt_degrees, 1) +
        " degrees, as by a tilted gantry: kept as shear (--even-slices makes them upright)");
  }
  if (geometry.deviation <= kEvenWithin) return geometry;
  const std::string shown = "shown " + fixed(along) + " mm apart, up to " +
                            fixed(geometry.deviation, geometry.deviation < 0.1 ? 3 : 2) +
                            " mm from where they lie (--even-slices resamples them)";
  if (gaps.missing > 0) {
    geometry.remarks.push_back(std::to_string(gaps.missing) +
                               (gaps.missing == 1 ? " slice is" : " slices are") +
                               " missing, the first behind slice " + std::to_string(gaps.first_before) +
                               " of " + std::to_string(count) + ": the others are " + shown);
  } else {
    geometry.remarks.push_back("the slices are not evenly spaced (" + fixed(least) + " to " +
                               fixed(greatest) + " mm): " + shown);
  }
  return geometry;
}

Affine3 upright_place(const std::vector<DicomImage>& images, DicomSlice first, const DicomGeometry& geometry,
                      Vec3d place, double step) {
  const DicomFrame& frame = images[first.image].frames[first.frame];
  const Vec3d normal = normalize(cross(frame.row, frame.column));
  const Vec3d origin = frame.position + place.x * frame.row + place.y * frame.column + place.z * normal;
  return to_world(frame, origin, geometry.spacing, step * normal);
}

}  // namespace gvx::io
