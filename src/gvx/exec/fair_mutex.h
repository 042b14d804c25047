/// \file
/// FairMutex: a lock that is given to those who wait for it in the order in which they came. So that of two
/// viewers that render all the time neither waits for more than one turn of the other.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <utility>

namespace gvx::exec {

class FairMutex {
 public:
  /// Held from FairMutex::take() to its end.
  class Turn {
   public:
    Turn() = default;
    Turn(Turn&& other) noexcept : mutex_(std::exchange(other.mutex_, nullptr)) {}
    Turn& operator=(Turn&& other) noexcept {
      if (this != &other) {
        end();
        mutex_ = std::exchange(other.mutex_, nullptr);
      }
      return *this;
    }
    ~Turn() { end(); }

    /// Lets the next one have it.
    void end() {
      if (mutex_ != nullptr) std::exchange(mutex_, nullptr)->leave();
    }

   private:
    friend class FairMutex;
    explicit Turn(FairMutex& mutex) : mutex_(&mutex) {}

    FairMutex* mutex_ = nullptr;
  };

  /// Waits for those who came before.
  [[nodiscard]] Turn take() {
    std::unique_lock lock(mutex_);
    const std::uint64_t number = next_++;
    changed_.wait(lock, [&] { return serving_ == number; });
    return Turn(*this);
  }

  /// How many wait while another has the turn.
  std::size_t waiting() const {
    const std::lock_guard lock(mutex_);
    return static_cast<std::size_t>(next_ > serving_ ? next_ - serving_ - 1 : 0);
  }
  /// Does anybody?
  bool contended() const { return waiting() > 0; }

 private:
  void leave() {
    {
      const std::lock_guard lock(mutex_);
      ++serving_;
    }
    changed_.notify_all();
  }

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::uint64_t next_ = 0, serving_ = 0;  // the number of the next one to come, and of the one that has it
};

}  // namespace gvx::exec
