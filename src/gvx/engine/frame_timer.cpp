#include "gvx/engine/frame_timer.h"

#include <algorithm>

namespace gvx::engine {
namespace {

// What a frame of too short a budget spends on rendering all the same: the small unit of work.
constexpr std::chrono::microseconds kLeastWork(200);
// A frame stops earlier by what the ones before were late, at most by one in so many parts of its budget;
// late ones are forgotten over some frames.
constexpr int kMostOfBudget = 4;
constexpr int kFramesToForget = 16;
// And by one in so many parts in any case: those that end late are few then.
constexpr int kSpareOfBudget = 20;

}  // namespace

exec::Deadline FrameTimer::deadline(std::chrono::nanoseconds budget) {
  late_ = std::min(late_, budget / kMostOfBudget);
  return std::max(start_ + budget - late_ - budget / kSpareOfBudget, Clock::now() + kLeastWork);
}

exec::Deadline FrameTimer::after(std::chrono::nanoseconds budget, double share) const {
  return start_ + std::chrono::duration_cast<std::chrono::nanoseconds>(share * budget);
}

void FrameTimer::end(exec::Deadline deadline) {
  const std::chrono::nanoseconds late = Clock::now() - deadline;
  late_ = std::max(late, late_ - late_ / kFramesToForget);
}

}  // namespace gvx::engine
