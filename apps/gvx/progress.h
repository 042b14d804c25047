/// \file
/// A progress bar with rate and time left, on standard error where that is a terminal and silent where it is
/// not.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

namespace gvx::app {

class Progress {
 public:
  /// `what` is done, such as "building"; rates are in bytes, or in `unit`s a second.
  Progress(std::string what, std::string unit);
  /// Clears the line.
  ~Progress();

  void show(std::uint64_t done, std::uint64_t all);

 private:
  std::string what_, unit_;
  bool terminal_;
  std::chrono::steady_clock::time_point start_, shown_;
};

}  // namespace gvx::app
