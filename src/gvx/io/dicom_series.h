/// \file
/// Which frames of many DICOM files belong together: series, as gvx takes them, and within a series the
/// frames of time, each a stack of slices sorted along their normal.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "gvx/core/result.h"
#include "gvx/io/dicom_image.h"

namespace gvx::io {

/// A frame of an image, by their indices.
struct DicomSlice {
  std::size_t image = 0, frame = 0;
};

/// The slices of a series in order.
struct DicomStack {
  /// Of each point in time the slices from the first along row x column; all of the same number.
  std::vector<std::vector<DicomSlice>> frames;
  std::string frames_differ_in;  ///< What told the frames apart: "echo time"; empty for one frame.
  /// Slices at one place that nothing tells apart: the one that is used, and the one that is not.
  std::vector<std::pair<DicomSlice, DicomSlice>> duplicates;
  std::size_t incomplete_frames = 0;  ///< That lack slices, and are left out.
};

/// Images with one SeriesInstanceUID, size, type of pixel and orientation.
struct DicomSeries {
  std::string
      label;  ///< By which --series chooses it: its SeriesNumber, with .1, .2 .. where several share it.
  std::vector<DicomSlice> slices;
  DicomStack stack;
};

/// Sorts the frames of all images into series, in the order of their numbers. Images that do not say where
/// they lie get positions one behind the other, by SliceLocation or InstanceNumber. An error where there are
/// more than 1024 series.
Result<std::vector<DicomSeries>> group_dicom(std::vector<DicomImage>& images);

}  // namespace gvx::io
