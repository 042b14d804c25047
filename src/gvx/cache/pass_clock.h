/// \file
/// PassClock: numbers the passes of all viewers, and knows since which pass what was stamped is in use: by
/// the last pass of any viewer that still marches. A viewer that has not marched for long counts no more.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "gvx/core/macros.h"

namespace gvx::cache {

class PassClock {
 public:
  /// One of those whose passes are numbered.
  enum class Walker : std::uint32_t {};

  Walker add() {
    const auto free = std::find(last_.begin(), last_.end(), kNone);
    if (free != last_.end()) {
      *free = kAtRest;
      return static_cast<Walker>(free - last_.begin());
    }
    last_.push_back(kAtRest);
    return static_cast<Walker>(last_.size() - 1);
  }
  void remove(Walker walker) { last(walker) = kNone; }

  /// The number of the walker's next pass: greater than all before. What its passes before have stamped is no
  /// longer in use for it.
  std::uint32_t begin(Walker walker) { return last(walker) = ++now_; }
  /// What the walker has stamped is no longer in use for it.
  void rest(Walker walker) { last(walker) = kAtRest; }

  /// What this pass or a later one has stamped is in use.
  std::uint32_t in_use_since() const {
    std::uint32_t since = now_ + 1;
    for (const std::uint32_t pass : last_) {
      const bool marches = pass <= now_ && now_ - pass <= kPatience;
      if (marches) since = std::min(since, pass);
    }
    return since;
  }

  /// So many passes of others after its own a walker is taken to be at rest.
  static constexpr std::uint32_t kPatience = 256;

 private:
  static constexpr std::uint32_t kAtRest = UINT32_MAX - 1, kNone = UINT32_MAX;

  std::uint32_t& last(Walker walker) {
    const auto index = static_cast<std::size_t>(walker);
    GVX_CHECK(index < last_.size() && last_[index] != kNone);
    return last_[index];
  }

  std::uint32_t now_ = 0;
  std::vector<std::uint32_t> last_;  // of each walker
};

}  // namespace gvx::cache
