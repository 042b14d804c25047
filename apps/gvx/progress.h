/// \file
/// How far a long piece of work is, on standard error: a bar with rate and time left where that is a
/// terminal, and a line every ten seconds where it is not.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>

namespace gvx::app {

/// The newest rate of something that is counted, over the last ten to twenty seconds.
class Rate {
 public:
  using Clock = std::chrono::steady_clock;

  explicit Rate(Clock::time_point start) : start_(start), points_{{start, 0}} {}

  void count(Clock::time_point now, std::uint64_t done);
  /// Of what is done a second; none in the first second, in which it would say little.
  std::optional<double> per_second() const;
  /// Until `all` is done, at the mean of this rate and that since the start; none in the first two seconds,
  /// and before a hundredth is done.
  std::optional<double> seconds_left(std::uint64_t all) const;

 private:
  struct Point {
    Clock::time_point time;
    std::uint64_t done = 0;
  };

  double seconds_since_start() const;

  Clock::time_point start_;
  std::deque<Point> points_;  // from the oldest that counts to the newest
};

class Progress {
 public:
  /// What is counted, which says how a rate is shown.
  enum class Unit { bytes, voxels, nodes, rays, none };

  /// `what` is done, such as "building". Says nothing at all where `quiet`.
  Progress(std::string what, Unit unit, bool quiet = false);
  /// Clears the bar.
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Cheap where nothing is to be shown yet. Work that is done in less than half a second shows nothing.
  void show(std::uint64_t done, std::uint64_t all);
  /// Clears the bar until it is shown again: for other lines on a terminal.
  void hide();

 private:
  std::string text(std::uint64_t done, std::uint64_t all) const;

  std::string what_;
  Unit unit_;
  bool quiet_, terminal_;
  bool bar_is_there_ = false;
  Rate::Clock::time_point start_, shown_;
  Rate rate_;
};

/// "40 s", "3 min 20 s", "2 h 05 min".
std::string duration_text(double seconds);

}  // namespace gvx::app
