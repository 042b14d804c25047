/// \file
/// Which files a folder of TIFF slices or a pattern such as "slices/z*.tif" or "z%04d.tif" means, and in
/// which order.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "gvx/core/result.h"

namespace gvx::io {

/// .tif, .tiff, .btf, .tf2 or .tf8, in any case.
bool is_tiff_name(std::string_view path);

/// Has the last part of the path a *, a ? or a number's place, and such a name that no file is called so?
bool is_tiff_pattern(const std::string& path);

/// Compares names as people do: digits by the number that they are, so that z2 stands before z10.
bool in_natural_order(std::string_view a, std::string_view b);

/// The TIFF files (by their names) of a folder, or those that match a pattern, in natural order; empty where
/// there are none. An error where the folder cannot be read or has more than kMostDataFiles. Names that are
/// no files, such as folders, pipes and links to nothing, are left out, and added to `no_files` without their
/// folder.
Result<std::vector<std::string>> tiff_names(const std::string& folder_or_pattern,
                                            std::vector<std::string>* no_files = nullptr);

/// Where numbers are missing in names that are sorted and otherwise alike: a line for a person that names the
/// first gap and counts the others, or nothing. The usual step from one number to the next is no gap.
std::string gaps_in_numbers(const std::vector<std::string>& names);

}  // namespace gvx::io
