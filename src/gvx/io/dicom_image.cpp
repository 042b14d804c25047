#include "gvx/io/dicom_image.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>

#include "gvx/io/dicom_mosaic.h"
#include "gvx/io/dicom_tags.h"
#include "gvx/io/header_text.h"

namespace gvx::io {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

Error wrong(const std::string& path, DicomTag tag, const std::string& what) {
  return file_error(path, dicom_tag_name(tag) + ": " + what);
}

bool finite(Vec3d v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/// The functional groups of a frame, its own before those that all share, and the file's own elements last.
struct Places {
  const DicomDataset* groups[2] = {nullptr, nullptr};
  const DicomDataset* file = nullptr;

  /// The first data set that holds `tag`, within `sequence` of a group or in the file itself.
  const DicomDataset* find(DicomTag sequence, DicomTag tag) const {
    for (const DicomDataset* group : groups) {
      const DicomDataset* const item = group != nullptr ? group->item(sequence) : nullptr;
      if (item != nullptr && item->find(tag) != nullptr) return item;
    }
    return file->find(tag) != nullptr ? file : nullptr;
  }

  std::optional<double> number(DicomTag sequence, DicomTag tag) const {
    const DicomDataset* const at = find(sequence, tag);
    return at != nullptr ? at->number(tag) : std::nullopt;
  }
};

/// Of a position's coordinates, in mm.
constexpr double kFarthest = 1e12;

/// Position and directions; false where one of them is absent. An error for a place beyond kFarthest.
Result<bool> read_place(const std::string& path, const Places& places, DicomFrame& frame) {
  const DicomDataset* at = places.find(tag::kPlanePositionSequence, tag::kPosition);
  const DicomDataset* turned = places.find(tag::kPlaneOrientationSequence, tag::kOrientation);
  // Nuclear medicine keeps both with the detector (PS3.3, C.8.4.11).
  if (const DicomDataset* detector = places.file->item(tag::kDetectorSequence)) {
    if (at == nullptr && detector->find(tag::kPosition) != nullptr) at = detector;
    if (turned == nullptr && detector->find(tag::kOrientation) != nullptr) turned = detector;
  }
  if (at == nullptr || turned == nullptr) return false;
  const std::vector<double> position = at->numbers(tag::kPosition),
                            directions = turned->numbers(tag::kOrientation);
  if (position.size() < 3 || directions.size() < 6) return false;
  frame.position = {position[0], position[1], position[2]};
  const Vec3d row(directions[0], directions[1], directions[2]),
      column(directions[3], directions[4], directions[5]);
  if (!finite(frame.position) || !finite(row) || !finite(column)) return false;
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(frame.position[axis]) > kFarthest) {
      return wrong(path, tag::kPosition,
                   "expected coordinates up to 1e12 mm, found " + number_text(frame.position[axis]));
    }
  }
  // They are unit vectors at right angles but for the digits they were written with.
  if (std::abs(length(row) - 1) > 0.05 || std::abs(length(column) - 1) > 0.05 ||
      std::abs(dot(row, column)) > 0.05)
    return false;
  frame.row = normalize(row);
  frame.column = normalize(column);
  return true;
}

bool usable_spacing(const std::vector<double>& spacing) {
  return spacing.size() >= 2 &&
         std::all_of(spacing.begin(), spacing.end(), [](double s) { return s > 1e-12 && s < 1e6; });
}

void read_spacing(const Places& places, DicomFrame& frame, DicomImage& image) {
  const DicomDataset* const measures = places.find(tag::kPixelMeasuresSequence, tag::kPixelSpacing);
  std::vector<double> spacing =
      measures != nullptr ? measures->numbers(tag::kPixelSpacing) : std::vector<double>{};
  if (!usable_spacing(spacing)) {
    if (!spacing.empty()) image.unusable_spacing = quoted(measures->text(tag::kPixelSpacing));
    spacing = places.file->numbers(tag::kImagerPixelSpacing);
  }
  if (!usable_spacing(spacing)) return;
  frame.row_spacing = spacing[0];
  frame.column_spacing = spacing[1];
}

/// A number that values are computed with: `otherwise` where the file does not say, or says no number, which
/// `image` keeps for a message.
double value_number(const DicomDataset* at, DicomTag tag, double otherwise, DicomImage& image) {
  const std::vector<double> numbers = at != nullptr ? at->numbers(tag) : std::vector<double>{};
  if (numbers.empty()) return otherwise;
  if (std::isfinite(numbers.front())) return numbers.front();
  if (image.unusable_value.empty()) {
    const bool is_text = find_dicom_tag(tag)->value == DicomValue::text;
    image.unusable_value = dicom_tag_name(tag) + ": expected a number, found " +
                           (is_text ? quoted(at->text(tag)) : number_text(numbers.front()));
    image.assumed_value = number_text(otherwise);
  }
  return otherwise;
}

/// The largest that a stored sample can be, without its sign.
double largest_sample(const DicomPixelFormat& format) {
  return format.floating ? 1 : std::ldexp(1.0, format.bits_stored - (format.is_signed ? 1 : 0));
}

Status read_values(const DicomHeader& header, const Places& places, DicomFrame& frame, DicomImage& image) {
  const DicomDataset* const with_slope = places.find(tag::kValueTransformationSequence, tag::kSlope);
  const double scaling = value_number(&header.elements, tag::kDoseScaling, 1, image);
  frame.slope = value_number(with_slope, tag::kSlope, scaling, image);
  frame.intercept = value_number(places.find(tag::kValueTransformationSequence, tag::kIntercept),
                                 tag::kIntercept, 0, image);
  const bool of_dose = with_slope == nullptr && header.elements.find(tag::kDoseScaling) != nullptr;
  const DicomTag slope_tag = of_dose ? tag::kDoseScaling : tag::kSlope;
  if (frame.slope == 0) return wrong(header.path, slope_tag, "expected a number other than 0");
  constexpr double kMost = std::numeric_limits<float>::max();
  const double most = std::abs(frame.slope) * largest_sample(image.format);
  if (!(most <= kMost)) {
    return wrong(
        header.path, slope_tag,
        "expected values that fit 32-bit floating point, found a slope of " + number_text(frame.slope));
  }
  if (!(most + std::abs(frame.intercept) <= kMost)) {
    return wrong(header.path, tag::kIntercept,
                 "expected values that fit 32-bit floating point, found an intercept of " +
                     number_text(frame.intercept));
  }
  return {};
}

double seconds_of(const std::string& time) {
  // HHMMSS.FFF, perhaps behind a date of 8 digits, perhaps with colons.
  std::string digits;
  for (const char c : time) {
    if (c != ':') digits += c;
  }
  double days = 0;
  if (digits.find_first_not_of("0123456789") >= 14 && digits.size() >= 14) {
    days = parse_number(digits.substr(0, 8)).value_or(0);
    digits.erase(0, 8);
  }
  const std::optional<double> number = parse_number(digits);
  return number ? days * 1e6 + *number : kUnknown;
}

/// The dimensions of an enhanced file that are not places in space.
std::vector<std::size_t> other_dimensions(const DicomDataset& elements) {
  std::vector<std::size_t> others;
  const std::vector<DicomDataset>& dimensions = elements.items(tag::kDimensionIndexSequence);
  for (std::size_t i = 0; i < dimensions.size(); ++i) {
    const std::vector<double> pointer = dimensions[i].numbers(tag::kDimensionIndexPointer);
    if (pointer.size() != 2) continue;
    const auto tag = static_cast<DicomTag>(pointer[0]) << 16 | static_cast<DicomTag>(pointer[1]);
    const bool in_space =
        tag == tag::kPosition || tag == 0x00209057 || tag == 0x00209056 || tag == tag::kOrientation;
    if (!in_space) others.push_back(i);
  }
  return others;
}

void read_keys(const Places& places, const std::vector<std::size_t>& dimensions, DicomFrame& frame) {
  const DicomDataset& file = *places.file;
  const auto set = [&](DicomKey key, std::optional<double> value) {
    frame.keys[static_cast<std::size_t>(key)] = value.value_or(kUnknown);
  };
  frame.keys.fill(kUnknown);
  const auto temporal = places.number(tag::kFrameContentSequence, tag::kTemporalIndex);
  set(DicomKey::temporal_position, temporal ? temporal : file.number(tag::kTemporalPosition));
  if (const DicomDataset* content = places.find(tag::kFrameContentSequence, tag::kDimensionIndexValues)) {
    const std::vector<double> values = content->numbers(tag::kDimensionIndexValues);
    for (std::size_t i = 0; i < std::min<std::size_t>(dimensions.size(), 3); ++i) {
      if (dimensions[i] >= values.size()) continue;
      frame.keys[static_cast<std::size_t>(DicomKey::dimension_0) + i] = values[dimensions[i]];
    }
  }
  set(DicomKey::echo_number, file.number(tag::kEchoNumbers));
  const auto echo = places.number(tag::kEchoSequence, tag::kEffectiveEchoTime);
  set(DicomKey::echo_time, echo ? echo : file.number(tag::kEchoTime));
  set(DicomKey::b_value, places.number(tag::kDiffusionSequence, tag::kBValue));
  const auto delay = places.number(tag::kCardiacTriggerSequence, tag::kCardiacDelay);
  set(DicomKey::trigger_time, delay ? delay : file.number(tag::kTriggerTime));
  // Any number will do that is the same for the same text, and exact in a double.
  set(DicomKey::image_type, static_cast<double>(std::hash<std::string>{}(file.text(tag::kImageType)) >> 12));
  set(DicomKey::acquisition, file.number(tag::kAcquisitionNumber));
  const DicomDataset* const content = places.find(tag::kFrameContentSequence, tag::kAcquisitionDateTime);
  set(DicomKey::acquisition_time, seconds_of(content != nullptr ? content->text(tag::kAcquisitionDateTime)
                                                                : file.text(tag::kAcquisitionTime)));
}

double stated_step(const Places& places) {
  const auto between = places.number(tag::kPixelMeasuresSequence, tag::kSpacingBetweenSlices);
  const auto thickness = places.number(tag::kPixelMeasuresSequence, tag::kSliceThickness);
  for (const auto& step : {between, thickness}) {
    if (step && *step != 0 && std::abs(*step) < 1e6) return *step;
  }
  return 0;
}

Vec3d normal_of(const DicomFrame& frame) {
  return normalize(cross(frame.row, frame.column));
}

bool changes_with_time(const DicomDataset& elements) {
  const std::vector<double> pointer = elements.numbers(tag::kFrameIncrementPointer);
  // FrameTime and FrameTimeVector.
  return pointer.size() >= 2 && pointer[0] == 0x0018 && (pointer[1] == 0x1063 || pointer[1] == 0x1065);
}

/// Frames of a file that says where the first lies, or none: PS3.3 gives them in steps, in the order of a
/// vector of slices (nuclear medicine) or at offsets (dose).
void place_in_steps(const DicomHeader& header, double step, DicomImage& image) {
  const std::vector<double> slices = header.elements.numbers(tag::kSliceVector);
  const std::vector<double> times = header.elements.numbers(tag::kTimeSliceVector);
  const std::vector<double> offsets = header.elements.numbers(tag::kGridOffsets);
  const bool in_time = changes_with_time(header.elements);
  for (std::size_t i = 0; i < image.frames.size(); ++i) {
    DicomFrame& frame = image.frames[i];
    double along = in_time ? 0 : static_cast<double>(i) * step;
    if (slices.size() == image.frames.size()) along = (slices[i] - 1) * step;
    // Offsets begin with 0 or, seldom, with the first frame's z.
    if (offsets.size() == image.frames.size() && std::isfinite(offsets[i])) along = offsets[i] - offsets[0];
    frame.position = frame.position + along * normal_of(frame);
    if (in_time) frame.keys[static_cast<std::size_t>(DicomKey::temporal_position)] = static_cast<double>(i);
    if (times.size() == image.frames.size())
      frame.keys[static_cast<std::size_t>(DicomKey::time_slice)] = times[i];
  }
}

/// Cuts a mosaic into its tiles, which lie in rows from the top left.
Status cut_into_tiles(const DicomHeader& header, const DicomMosaic& mosaic, double step, DicomImage& image) {
  const auto across = static_cast<std::int64_t>(std::ceil(std::sqrt(static_cast<double>(mosaic.tiles))));
  if (image.format.columns % across != 0 || image.format.rows % across != 0 || image.frames.size() != 1) {
    return file_error(header.path, "a mosaic of " + std::to_string(mosaic.tiles) +
                                       " slices: expected pixels that " + std::to_string(across) + " x " +
                                       std::to_string(across) + " tiles share evenly, found " +
                                       std::to_string(image.format.columns) + " x " +
                                       std::to_string(image.format.rows));
  }
  image.tiles = mosaic.tiles;
  image.tiles_across = across;
  DicomFrame first = image.frames.front();
  // The position is that of the corner of an image as large as the mosaic, around the slice's centre.
  first.position =
      first.position +
      0.5 * first.column_spacing * static_cast<double>(image.format.columns - image.slice_columns()) *
          first.row +
      0.5 * first.row_spacing * static_cast<double>(image.format.rows - image.slice_rows()) * first.column;
  Vec3d normal = normal_of(first);
  if (mosaic.normal && dot(*mosaic.normal, normal) < 0) normal = -normal;
  image.frames.clear();
  for (std::int64_t tile = 0; tile < mosaic.tiles; ++tile) {
    DicomFrame frame = first;
    frame.tile = tile;
    frame.position = first.position + static_cast<double>(tile) * std::abs(step) * normal;
    image.frames.push_back(frame);
  }
  return {};
}

}  // namespace

const char* dicom_key_name(DicomKey key) {
  switch (key) {
    case DicomKey::temporal_position:
      return "temporal position";
    case DicomKey::dimension_0:
    case DicomKey::dimension_1:
    case DicomKey::dimension_2:
      return "dimension index";
    case DicomKey::time_slice:
      return "time slice";
    case DicomKey::echo_number:
      return "echo number";
    case DicomKey::echo_time:
      return "echo time";
    case DicomKey::b_value:
      return "b-value";
    case DicomKey::trigger_time:
      return "trigger time";
    case DicomKey::image_type:
      return "image type";
    case DicomKey::acquisition:
      return "acquisition number";
    case DicomKey::acquisition_time:
      break;
  }
  return "acquisition time";
}

Result<DicomImage> interpret_dicom(const DicomHeader& header) {
  const DicomDataset& e = header.elements;
  DicomImage image;
  image.path = header.path;
  GVX_ASSIGN(image.format, interpret_format(header));
  GVX_ASSIGN(const std::int64_t frames, count_frames(header, image.format));
  image.surplus_bytes = surplus_pixel_bytes(header, image.format, frames);
  image.series_uid = e.text(tag::kSeriesUid);
  image.series_number = e.text(tag::kSeriesNumber);
  image.description = e.text(tag::kSeriesDescription);
  image.modality = e.text(tag::kModality);
  image.rescale_type = e.text(tag::kRescaleType);
  image.instance = e.count(tag::kInstanceNumber).value_or(-1);
  image.slice_location = e.number(tag::kSliceLocation).value_or(kUnknown);
  image.stated_tilt = e.number(tag::kGantryTilt).value_or(0);
  image.has_value_table = e.item(tag::kModalityLut) != nullptr;

  const std::vector<DicomDataset>& own = e.items(tag::kPerFrameGroups);
  const std::vector<std::size_t> dimensions = other_dimensions(e);
  if (!own.empty() && own.size() < static_cast<std::size_t>(frames)) {
    return wrong(header.path, tag::kPerFrameGroups,
                 "expected an item for each of " + std::to_string(frames) + " frames, found " +
                     std::to_string(own.size()));
  }
  // A packed file does not show how many frames it holds; each takes some bytes at least.
  if (!header.pixel_bytes && frames > 1 && own.empty() && frames > 65536) {
    return wrong(header.path, tag::kNumberOfFrames,
                 "expected at most 65536 packed frames, found " + std::to_string(frames));
  }
  double step = 0;
  std::int64_t placed = 0;
  for (std::int64_t i = 0; i < frames; ++i) {
    const Places places{
        {own.empty() ? nullptr : &own[static_cast<std::size_t>(i)], e.item(tag::kSharedGroups)}, &e};
    DicomFrame frame;
    frame.number = i;
    GVX_ASSIGN(const bool is_placed, read_place(header.path, places, frame));
    placed += is_placed ? 1 : 0;
    read_spacing(places, frame, image);
    GVX_TRY(read_values(header, places, frame, image));
    read_keys(places, dimensions, frame);
    if (i == 0) step = stated_step(places);
    image.frames.push_back(frame);
  }
  if (placed != 0 && placed != frames) {
    return wrong(header.path, tag::kPosition,
                 "expected the place of all " + std::to_string(frames) + " frames, found those of " +
                     std::to_string(placed));
  }
  image.placed = placed == frames;
  image.slice_step = std::abs(step);
  if (const auto mosaic = find_mosaic(e); mosaic && image.placed) {
    GVX_TRY(cut_into_tiles(header, *mosaic, step == 0 ? 1 : step, image));
  } else if (own.empty() && frames > 1) {
    const double in_plane = image.frames.front().column_spacing;
    place_in_steps(header, step != 0 ? step : in_plane > 0 ? in_plane : 1, image);
    image.stacked = true;
  }
  return image;
}

}  // namespace gvx::io
