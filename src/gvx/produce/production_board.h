/// \file
/// The parts of Production that outlive it where producers still hold sinks. Included by production*.cpp
/// only.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "gvx/core/time_sum.h"
#include "gvx/produce/production.h"

namespace gvx::produce {

/// What Production's threads and the sinks of its batches share.
class Production::Board {
 public:
  /// A batch to start.
  struct Batch {
    std::shared_ptr<const Producer> producer;
    std::shared_ptr<const TreeDescription> tree;
    bool in_host_memory = true;
    std::vector<ElementKey> keys;  ///< of one tree and kind
  };

  explicit Board(int threads) : threads_(static_cast<std::size_t>(threads)) {}

  TreeId add(std::shared_ptr<const Producer> producer);
  void remove(TreeId tree);
  /// Calls change(demand), and wakes all that may have to do with it.
  template <typename Change>
  auto change_demand(Change change) {
    const Waking waking(*this);
    const std::lock_guard lock(mutex_);
    return change(demand_);
  }
  /// The same, of what it only asks.
  template <typename Ask>
  auto ask_demand(Ask ask) const {
    const std::lock_guard lock(mutex_);
    return ask(demand_);
  }

  std::vector<FinishedElement> take_finished();
  void wait_until(std::optional<ClientId> client, Deadline deadline);
  /// Forgets all trees; next() returns nothing from now on.
  void stop();

  /// Waits for a batch to begin; nothing once production stops.
  std::optional<Batch> next();
  void finish(const ElementKey& key, Result<Element> made);
  void give_up(const ElementKey& key);
  /// Reports a mistake of the producer's with an element that it had finished before.
  void spoil(const ElementKey& key, Error error);
  /// A batch has no elements left that are under way.
  void end_batch(TreeId tree);

  TimeSum making_time;

 private:
  struct Tree {
    std::shared_ptr<const Producer> producer;
    std::shared_ptr<const TreeDescription> description;
    std::size_t most_in_batch = 1, most_under_way = 1, under_way = 0;  // the last two: batches
    bool in_host_memory = true;
  };
  /// Wakes threads at its end, when the mutex is free again.
  struct Waking {
    explicit Waking(Board& b) : board(b) {}
    Waking(const Waking&) = delete;
    Waking& operator=(const Waking&) = delete;
    ~Waking() {
      board.work_came_.notify_all();
      board.work_done_.notify_all();
    }
    Board& board;
  };

  std::size_t room(TreeId tree, std::size_t waiting) const;

  const std::size_t threads_;
  mutable std::mutex mutex_;
  std::condition_variable work_came_, work_done_;
  std::map<std::uint32_t, Tree> trees_;
  std::uint32_t next_tree_ = 0;
  Demand demand_;
  std::vector<FinishedElement> finished_;
  bool stopping_ = false;
};

/// Sees to it that each element of a batch is handed over exactly once.
class Production::BatchSink final : public ElementSink {
 public:
  BatchSink(std::shared_ptr<Board> board, const Board::Batch& batch)
      : board_(std::move(board)),
        tree_(batch.tree),
        in_host_memory_(batch.in_host_memory),
        keys_(batch.keys),
        states_(batch.keys.size(), State::open),
        open_(batch.keys.size()) {}
  BatchSink(const BatchSink&) = delete;
  BatchSink& operator=(const BatchSink&) = delete;
  ~BatchSink() override;

  void complete(std::size_t element, Result<Element> made) override;
  bool cancelled(std::size_t element) override;
  void drop(std::size_t element) override;
  /// What is not handed over yet is an error, and is no longer expected.
  void fail(const std::string& why);

 private:
  /// Told: that nobody wants it. Failed: what comes of it now is ignored.
  enum class State : std::uint8_t { open, told, done, failed };

  /// Closes an element that is open, and returns in which state it was.
  State close(std::size_t element, State state);
  /// After an element has been closed and the board knows.
  void count_closed();
  std::string name(std::size_t element) const {
    return name_of(keys_.at(element).node, keys_.at(element).kind);
  }

  const std::shared_ptr<Board> board_;
  const std::shared_ptr<const TreeDescription> tree_;
  const bool in_host_memory_;
  const std::vector<ElementKey> keys_;
  std::mutex mutex_;
  std::vector<State> states_;
  std::size_t open_;  // elements that the board waits for
};

}  // namespace gvx::produce
