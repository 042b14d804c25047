/// \file
/// LabelTable: names and colours of labels, which are whole numbers that name classes.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "gvx/core/vec.h"
#include "gvx/scene/transfer_function.h"

namespace gvx::scene {

struct LabelEntry {
  std::string name;
  std::optional<Vec3d> color = {};  ///< display (sRGB), 0 to 1; none: as without a table
  double opacity = 1;               ///< 0 to 1, relative to other labels'

  bool operator==(const LabelEntry&) const = default;
};

/// By label.
using LabelTable = std::map<std::uint32_t, LabelEntry>;

/// A colour for each label, 0 to `labels` - 1, told apart as well as can be; 0 is transparent.
TransferFunction label_colors(std::uint32_t labels);

/// The same with the colours and opacities of a table for the labels that it has; 0 is transparent.
TransferFunction label_colors(std::uint32_t labels, const LabelTable& table);

}  // namespace gvx::scene
