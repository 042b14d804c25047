/// \file
/// Checks of a command's outputs before it begins: none may be an input, and each must be writable.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "gvx/core/result.h"

namespace gvx::app {

/// A file to write.
struct Output {
  std::string flag;  ///< that names it: "-o"
  std::string path;
  /// Made in turn after others: only then is it found whether it can be written.
  bool later = false;
};

/// An error where an output is one of the inputs, by whatever name or link, where two outputs are one file,
/// or where an output cannot be written. The unfinished file beside an output (PATH.partial) counts as well.
/// Devices and pipes may be named more than once. `inputs` is only called where an output exists.
Status check_outputs(std::span<const Output> outputs,
                     const std::function<std::vector<std::string>()>& inputs);

/// An error where `path` is there and no regular file: stores cannot be written to devices and pipes.
Status check_is_file(const Output& output);

}  // namespace gvx::app
