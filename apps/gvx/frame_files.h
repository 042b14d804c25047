/// \file
/// The numbered pictures of an animation: which frames, and the name of each.
#pragma once

#include <string>

#include "gvx/core/result.h"

namespace gvx::app {

struct FrameRange {
  int first = 1, last = 1;

  int count() const { return last - first + 1; }
};

/// "A-B", or "N" for 1 to N.
Result<FrameRange> parse_frames(const std::string& text);

/// Four digits in the place of a pattern such as %04d, of which the digits are how many; without one before
/// the suffix: out.png becomes out.0012.png.
std::string frame_file(const std::string& path, int frame);

}  // namespace gvx::app
