#include "gvx/engine/renderer.h"

#include <algorithm>
#include <string>
#include <utility>

namespace gvx::engine {
namespace {

// How long a frame has its turn.
constexpr std::chrono::milliseconds kTurn(33);

}  // namespace

struct Renderer::Frame::State {
  Viewer* viewer = nullptr;
  FrameRequest request;
  std::atomic<bool> cancelled{false};
  std::chrono::nanoseconds left{0};  // of the budget

  mutable std::mutex mutex;
  mutable std::condition_variable changed;
  std::optional<Status> result;

  void finish(Status status) {
    {
      const std::lock_guard lock(mutex);
      result = std::move(status);
    }
    changed.notify_all();
  }
  /// Renders for one turn; the result, if it is done.
  std::optional<Status> turn();
};

std::optional<Status> Renderer::Frame::State::turn() {
  if (cancelled) return Error{"cancelled"};
  const auto begin = std::chrono::steady_clock::now();
  const bool limited = request.budget.has_value();
  const std::chrono::nanoseconds time = limited ? std::min<std::chrono::nanoseconds>(left, kTurn) : kTurn;
  if (const Status status = viewer->render_for(time); !status.ok()) return status;
  if (request.on_progress) request.on_progress(*viewer);
  if (viewer->converged()) return Status();
  left -= std::chrono::steady_clock::now() - begin;
  if (limited && left.count() <= 0) return Status();
  return std::nullopt;
}

bool Renderer::Frame::done() const {
  const std::lock_guard lock(state_->mutex);
  return state_->result.has_value();
}

Status Renderer::Frame::wait() const {
  std::unique_lock lock(state_->mutex);
  state_->changed.wait(lock, [&] { return state_->result.has_value(); });
  return *state_->result;
}

std::optional<Status> Renderer::Frame::wait_for(std::chrono::nanoseconds time) const {
  std::unique_lock lock(state_->mutex);
  state_->changed.wait_for(lock, time, [&] { return state_->result.has_value(); });
  return state_->result;
}

void Renderer::Frame::cancel() {
  state_->cancelled = true;
}

Renderer::Renderer() : thread_([this] { work(); }) {}

Renderer::~Renderer() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
    for (const auto& frame : frames_) frame->cancelled = true;
  }
  came_.notify_all();
  thread_.join();
}

Renderer::Frame Renderer::start(Viewer& viewer, FrameRequest request) {
  auto state = std::make_shared<Frame::State>();
  state->viewer = &viewer;
  state->left = request.budget.value_or(std::chrono::nanoseconds(0));
  state->request = std::move(request);
  {
    const std::lock_guard lock(mutex_);
    frames_.push_back(state);
  }
  came_.notify_all();
  return Frame(std::move(state));
}

void Renderer::work() {
  std::unique_lock lock(mutex_);
  while (true) {
    came_.wait(lock, [&] { return stopping_ || !frames_.empty(); });
    if (frames_.empty()) return;
    const std::shared_ptr<Frame::State> frame = frames_.front();
    frames_.pop_front();
    if (stopping_) frame->cancelled = true;
    lock.unlock();
    std::optional<Status> result = frame->turn();
    const bool done = result.has_value();
    if (done) frame->finish(std::move(*result));
    lock.lock();
    if (!done) frames_.push_back(frame);
  }
}

Status Renderer::frame(std::span<Viewer* const> viewers, std::chrono::nanoseconds budget) {
  const auto begin = std::chrono::steady_clock::now();
  for (std::size_t i = 0; i < viewers.size(); ++i) {
    if (viewers[i] == nullptr) return Error{"viewers[" + std::to_string(i) + "]: none"};
    if (viewers[i]->converged()) continue;
    std::size_t unfinished = 0;
    for (std::size_t j = i; j < viewers.size(); ++j) {
      unfinished += viewers[j] != nullptr && !viewers[j]->converged() ? 1 : 0;
    }
    const std::chrono::nanoseconds left = budget - (std::chrono::steady_clock::now() - begin);
    GVX_TRY(viewers[i]->render_for(left / static_cast<std::int64_t>(unfinished)));
  }
  return {};
}

}  // namespace gvx::engine
