/// \file
/// SampledBounds: estimates the bounds of a function's values in a box, for functions whose bounds are not
/// known. The engine reports a brick that breaks them (EngineOptions::warn).
#pragma once

#include <cstdint>
#include <optional>

#include "gvx/core/ray.h"
#include "gvx/core/result.h"
#include "gvx/core/voxel.h"
#include "gvx/produce/field.h"

namespace gvx::produce {

struct SampledBoundsOptions {
  /// The width of the smallest thing that the function shows, in tree space, the cube [0, 1]^3. Samples are
  /// no more than half of it apart. What is smaller may be missed.
  double feature = 1.0 / 64;
  /// Samples along each axis of a box, at least; 2 to 32. A call takes (samples + 2)^3 values or more. Fewer
  /// make bounds wide, more take time.
  std::uint32_t samples = 8;
  /// How far the bounds go beyond the samples. The unit is the largest difference between two neighbours
  /// along x, plus the same along y and along z. 0.75 is enough if the function is no steeper between samples
  /// than from one to the next.
  double margin = 1;
  /// The range of all values, if it is known. Bounds stay within it. If it is not known, the constructor
  /// samples the whole cube.
  std::optional<ValueRange> all = {};
};

/// Bounds for FieldProducer. A box is divided into at least `samples` cells along each axis, and one value is
/// taken in each cell. The places within the cells vary, so that a periodic function does not look constant.
/// The same box always has the same bounds. If all samples are equal, the box counts as constant. Boxes that
/// need more than 32 samples along an axis have the bounds of all values.
class SampledBounds {
 public:
  /// An error if there is no function, or an option is out of its range.
  static Result<SampledBounds> create(FunctionField::Values values, const SampledBoundsOptions& options);

  /// The bounds in a box in tree space. Thread-safe if the function is.
  ValueRange operator()(const Box3d& box) const;

  /// The bounds of all values in the cube, and in a quarter of its width around it.
  ValueRange all() const { return all_; }

 private:
  SampledBounds(FunctionField::Values values, const SampledBoundsOptions& options);
  ValueRange sample(const Box3d& box, std::uint32_t cells, ValueRange within) const;

  FunctionField::Values values_;
  SampledBoundsOptions options_;
  ValueRange all_;
};

}  // namespace gvx::produce
