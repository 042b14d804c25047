/// \file
/// FrameTimer: when a frame with a budget is to stop, so that it ends in time. Work that was begun is
/// finished: frames stop as much earlier as those before were late.
#pragma once

#include <chrono>

#include "gvx/exec/tile_grid.h"

namespace gvx::engine {

class FrameTimer {
 public:
  using Clock = std::chrono::steady_clock;

  void begin() { start_ = Clock::now(); }
  /// When a frame of this budget is to stop. However short it is, each frame gets somewhere.
  exec::Deadline deadline(std::chrono::nanoseconds budget);
  /// A share of a frame's budget after it began.
  exec::Deadline after(std::chrono::nanoseconds budget, double share) const;
  /// It ended, and was to end at `deadline`.
  void end(exec::Deadline deadline);

  double milliseconds() const {
    return std::chrono::duration<double, std::milli>(Clock::now() - start_).count();
  }

 private:
  Clock::time_point start_;
  std::chrono::nanoseconds late_{0};  // by which frames were
};

}  // namespace gvx::engine
