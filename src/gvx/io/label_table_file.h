/// \file
/// Names and colours of labels, as other programs write them.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "gvx/core/result.h"
#include "gvx/scene/label_table.h"

namespace gvx::io {

/// Reads a text file of at most 16 MiB, a label a line; blank lines and those that begin with # say nothing.
/// An error names the line. The layout is told by what the lines hold:
///
/// - FreeSurfer's lookup table (FreeSurferColorLUT.txt): number, name, red, green, blue and a fourth number
///   that FreeSurfer takes as transparency, 0 to 255. 3D Slicer writes the same with opacity: so it is read
///   where it is 255 for most labels.
/// - ITK-SNAP's label descriptions: number, red, green, blue, opacity 0 to 1, two visibilities 0 or 1, and
///   the name in quotation marks. Labels whose first visibility is 0 are transparent.
/// - Number and name, as MRIcron has it; a third word, which is the number again or above 255, says nothing.
/// - CSV or TSV, as BIDS has it: a first line that names the columns; "index" (or "label", "value", "id"),
///   "name", and "color" (#rrggbb) or "r", "g", "b", 0 to 255. Other columns say nothing. Without a colour a
///   label looks as without a table.
///
/// Either all lines have colours or none; CSV and TSV may leave a field of colours empty. Colours from 0 to
/// 255 are whole numbers. Two different lines for a label are an error that names both; in FreeSurfer's
/// layout the later one counts, and a line of `warnings` names both.
Result<scene::LabelTable> read_label_table(const std::string& path,
                                           std::vector<std::string>* warnings = nullptr);

/// Is the name that of a table, not of a volume?
bool is_label_table_name(std::string_view name);

}  // namespace gvx::io
