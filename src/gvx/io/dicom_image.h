/// \file
/// DicomImage: what the header of one DICOM file says of its frames: where each lies in the patient, how its
/// pixels are stored, and what tells it from other frames at the same place.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "gvx/core/result.h"
#include "gvx/core/vec.h"
#include "gvx/io/dicom_elements.h"
#include "gvx/io/dicom_format.h"

namespace gvx::io {

/// What may tell frames at the same place apart, the likeliest first.
enum class DicomKey {
  temporal_position,
  dimension_0,
  dimension_1,
  dimension_2,
  time_slice,
  echo_number,
  echo_time,
  b_value,
  trigger_time,
  image_type,
  acquisition,
  acquisition_time,
};
inline constexpr int kDicomKeys = 12;

/// "echo time": for messages.
const char* dicom_key_name(DicomKey key);

/// One slice: a frame of a file, or a tile of a mosaic.
struct DicomFrame {
  std::int64_t number = 0;  ///< Of the stored frame in its file.
  std::int64_t tile = -1;   ///< Of a mosaic.
  Vec3d position;           ///< Of the centre of the first pixel, in mm: x to the left, y to the back, z up.
  Vec3d row{1, 0, 0};       ///< Unit vector along a row: where the column's number grows.
  Vec3d column{0, 1, 0};
  double row_spacing = 0;     ///< Between rows, in mm; 0 where the file does not say.
  double column_spacing = 0;  ///< Between columns.
  double slope = 1, intercept = 0;
  std::array<double, kDicomKeys> keys;  ///< By DicomKey; NaN where the file does not say.
};

struct DicomImage {
  std::string path;
  DicomPixelFormat format;
  std::string series_uid, series_number, description, modality, rescale_type;
  std::int64_t instance = -1;  ///< -1 where the file does not say.
  double slice_location = std::numeric_limits<double>::quiet_NaN();
  double slice_step = 0;         ///< From slice to slice as the file says, in mm; 0 where it does not.
  double stated_tilt = 0;        ///< Of the gantry, in degrees.
  bool placed = false;           ///< The file says where its frames lie.
  bool stacked = false;          ///< It does not, but they lie one behind the other: `position` shows it.
  bool has_value_table = false;  ///< A modality LUT, which is not applied.
  /// The first slope or intercept that is no number, and what is assumed; empty where there is none.
  std::string unusable_value, assumed_value;
  std::string unusable_spacing;     ///< PixelSpacing as the file writes it, if it cannot be used.
  std::uint64_t surplus_bytes = 0;  ///< Behind the pixels, in their element.
  std::int64_t tiles = 0;           ///< Of a mosaic; 0 for others.
  std::int64_t tiles_across = 0;
  std::vector<DicomFrame> frames;

  /// Of a slice.
  std::int64_t slice_columns() const { return tiles > 0 ? format.columns / tiles_across : format.columns; }
  std::int64_t slice_rows() const { return tiles > 0 ? format.rows / tiles_across : format.rows; }
};

/// An error where a field that the pixels need is absent or impossible, or where the file is too short for
/// them. The header must have pixels.
Result<DicomImage> interpret_dicom(const DicomHeader& header);

}  // namespace gvx::io
