/// \file
/// SampledBounds: bounds of a function's values in a box, for functions whose bounds nobody has worked out.
/// They are an estimate. The engine reports a brick that breaks them (EngineOptions::warn).
#pragma once

#include <cstdint>
#include <optional>

#include "gvx/core/ray.h"
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
  /// How much wider than the samples bounds are. The unit is the largest difference between two neighbours
  /// along x, plus the same along y and along z. Where the function is about as steep between samples as from
  /// one to the next, 0.75 is enough.
  double margin = 1;
  /// Of all values, where that is known: bounds stay within it. Otherwise the constructor samples the whole
  /// cube.
  std::optional<ValueRange> all = {};
};

/// To be given to FieldProducer as its bounds. A box is cut into cells, at least `samples` along an axis, and
/// one value is taken in each, at places that do not repeat: a periodic function does not look constant. The
/// same box always has the same bounds. Where all samples are of one value, the box is taken to be of that
/// value. Boxes that would take more than 32 samples along an axis have the bounds of all values.
class SampledBounds {
 public:
  SampledBounds(FunctionField::Values values, const SampledBoundsOptions& options);

  /// Bounds of the values in a box in tree space. Thread-safe where the function is.
  ValueRange operator()(const Box3d& box) const;

  /// Of all values in the cube and a quarter around it.
  ValueRange all() const { return all_; }

 private:
  ValueRange sample(const Box3d& box, std::uint32_t cells, ValueRange within) const;

  FunctionField::Values values_;
  SampledBoundsOptions options_;
  ValueRange all_;
};

}  // namespace gvx::produce
