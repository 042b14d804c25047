/// \file
/// Where the slices of a DICOM stack lie: one affine map from voxels to the patient, and how far the slices
/// are from it. Spacing comes from positions, never from what the file says of thickness (PS3.3, C.7.6.2).
#pragma once

#include <span>
#include <string>
#include <vector>

#include "gvx/core/affine.h"
#include "gvx/io/dicom_series.h"

namespace gvx::io {

struct DicomGeometry {
  Affine3 voxel_to_world;  ///< As VolumeDescription has it.
  bool anatomical = false;
  std::vector<Vec3d> places;  ///< Of the slices' first pixels, from that of the first: along rows, columns
                              ///< and the normal, in mm.
  Vec3d spacing;              ///< Of columns and rows, and from slice to slice along the normal.
  double tilt_degrees = 0;    ///< Between the way from slice to slice and the normal.
  double deviation = 0;       ///< The farthest of a slice from where voxel_to_world puts it, in mm.
  std::vector<std::string> remarks;

  /// Does each slice lie straight above the last at even steps?
  bool upright() const;
};

/// Slices that are farther than this from even steps, in mm, or tilted by more degrees, are reported.
inline constexpr double kEvenWithin = 0.01, kUprightWithin = 0.25;

/// Of the slices of one frame.
DicomGeometry place_slices(const std::vector<DicomImage>& images, std::span<const DicomSlice> slices);

/// The map to the world of an image whose first pixel's centre is at `place`, from `geometry`'s first, in mm
/// along rows, columns and the normal.
Affine3 upright_place(const std::vector<DicomImage>& images, DicomSlice first, const DicomGeometry& geometry,
                      Vec3d place, double step);

}  // namespace gvx::io
