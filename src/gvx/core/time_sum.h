/// \file
/// TimeSum: how long threads were at something, all of them together.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <type_traits>

namespace gvx {

class TimeSum {
 public:
  /// Adds the time from its making to its end.
  class Span {
   public:
    explicit Span(TimeSum& sum) : sum_(sum) {}
    Span(const Span&) = delete;
    Span& operator=(const Span&) = delete;
    ~Span() {
      sum_.nanoseconds_.fetch_add(static_cast<std::int64_t>((Clock::now() - begun_).count()),
                                  std::memory_order_relaxed);
    }

   private:
    using Clock = std::chrono::steady_clock;
    static_assert(std::is_same_v<Clock::duration, std::chrono::nanoseconds>);
    TimeSum& sum_;
    Clock::time_point begun_ = Clock::now();
  };

  std::chrono::nanoseconds total() const {
    return std::chrono::nanoseconds(nanoseconds_.load(std::memory_order_relaxed));
  }
  double milliseconds() const { return std::chrono::duration<double, std::milli>(total()).count(); }

 private:
  std::atomic<std::int64_t> nanoseconds_{0};
};

}  // namespace gvx
