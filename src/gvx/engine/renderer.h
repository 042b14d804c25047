/// \file
/// Renderer: renders viewers' frames on a thread of its own. Who asks for a frame gets a handle at once, and
/// may wait, look how far it is, or cancel it. Frames of several viewers take turns.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <thread>

#include "gvx/core/result.h"
#include "gvx/engine/viewer.h"

namespace gvx::engine {

/// How long a frame may take, and who is told how it comes on.
struct FrameRequest {
  /// None: the frame is finished when its picture is exact.
  std::optional<std::chrono::nanoseconds> budget = {};
  /// Called on the renderer's thread each time that the viewer's picture is better than before: it may be
  /// copied then, by Viewer::picture().
  std::function<void(const Viewer&)> on_progress = {};
};

class Renderer {
 public:
  /// A frame that was asked for. Copies are of the same frame.
  class Frame {
   public:
    /// Is it finished, cancelled or failed?
    bool done() const;
    /// Waits until it is; an error if it failed. That of a cancelled frame is "cancelled".
    Status wait() const;
    /// The same, but no longer than this; none if it is not done then.
    std::optional<Status> wait_for(std::chrono::nanoseconds time) const;
    /// Stops it soon. What is rendered of it stays with its viewer, which goes on from there if it is asked
    /// again.
    void cancel();

   private:
    friend class Renderer;
    struct State;
    explicit Frame(std::shared_ptr<State> state) : state_(std::move(state)) {}

    std::shared_ptr<State> state_;
  };

  Renderer();
  /// Cancels what is not done.
  ~Renderer();
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;

  /// Has a frame of the viewer rendered. Until it is done the viewer must live, and only on_progress may call
  /// its functions.
  Frame start(Viewer& viewer, FrameRequest request);

  /// Renders a frame of each viewer on the calling thread, all of them within the budget: each gets an equal
  /// share, and what the exact ones do not need goes to the others.
  static Status frame(std::span<Viewer* const> viewers, std::chrono::nanoseconds budget);

 private:
  void work();

  std::mutex mutex_;
  std::condition_variable came_;
  std::deque<std::shared_ptr<Frame::State>> frames_;  // in turns
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace gvx::engine
