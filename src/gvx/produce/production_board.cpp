#include "gvx/produce/production_board.h"

#include <algorithm>
#include <utility>

#include "gvx/produce/examine_element.h"

namespace gvx::produce {

TreeId Production::Board::add(std::shared_ptr<const Producer> producer) {
  Tree tree;
  tree.description = std::make_shared<TreeDescription>(producer->description());
  tree.most_in_batch = std::max<std::size_t>(producer->batching().most, 1);
  const std::size_t most = producer->most_under_way();
  tree.most_under_way = most > 0 ? most : threads_;
  tree.in_host_memory = makes_host_memory(*producer);
  tree.producer = std::move(producer);
  const std::lock_guard lock(mutex_);
  const TreeId id(next_tree_++);
  trees_.emplace(id.value, std::move(tree));
  demand_.add_tree(id);
  return id;
}

void Production::Board::remove(TreeId id) {
  Tree gone;  // dies when the mutex is free again: a producer may let go of its sinks then
  const Waking waking(*this);
  const std::lock_guard lock(mutex_);
  const auto tree = trees_.find(id.value);
  if (tree == trees_.end()) return;
  gone = std::move(tree->second);
  trees_.erase(tree);
  demand_.remove_tree(id);
  std::erase_if(finished_, [&](const FinishedElement& finished) { return finished.key.tree == id; });
}

std::vector<FinishedElement> Production::Board::take_finished() {
  const std::lock_guard lock(mutex_);
  for (const FinishedElement& finished : finished_) demand_.take(finished.key);
  return std::exchange(finished_, {});
}

void Production::Board::wait_until(std::optional<ClientId> client, Deadline deadline) {
  const auto left = [&](Stage stage) {
    return client ? demand_.count(*client, stage) : demand_.count(stage);
  };
  std::unique_lock lock(mutex_);
  work_done_.wait_until(lock, deadline, [&] {
    return !finished_.empty() || left(Stage::waiting) + left(Stage::under_way) == 0;
  });
}

void Production::Board::stop() {
  std::map<std::uint32_t, Tree> gone;
  const Waking waking(*this);
  const std::lock_guard lock(mutex_);
  stopping_ = true;
  gone = std::exchange(trees_, {});
  for (const auto& [id, tree] : gone) demand_.remove_tree(TreeId(id));
  finished_.clear();
}

/// How many elements of a tree may begin at once: no more than a thread's share of what waits, so that what
/// is most urgent is begun by all threads.
std::size_t Production::Board::room(TreeId id, std::size_t waiting) const {
  const Tree& tree = trees_.at(id.value);
  if (tree.under_way >= tree.most_under_way) return 0;
  return std::clamp<std::size_t>(waiting / threads_, 1, tree.most_in_batch);
}

std::optional<Production::Board::Batch> Production::Board::next() {
  std::unique_lock lock(mutex_);
  std::vector<ElementKey> keys;
  work_came_.wait(lock, [&] {
    if (stopping_) return true;
    keys = demand_.begin([&](TreeId tree, std::size_t waiting) { return room(tree, waiting); });
    return !keys.empty();
  });
  if (keys.empty()) return std::nullopt;
  Tree& tree = trees_.at(keys.front().tree.value);
  ++tree.under_way;
  return Batch{tree.producer, tree.description, tree.in_host_memory, std::move(keys)};
}

void Production::Board::finish(const ElementKey& key, Result<Element> made) {
  const Waking waking(*this);
  const std::lock_guard lock(mutex_);
  if (!trees_.contains(key.tree.value)) return;
  demand_.finish(key);
  finished_.push_back({key, std::move(made)});
}

void Production::Board::give_up(const ElementKey& key) {
  const Waking waking(*this);
  const std::lock_guard lock(mutex_);
  demand_.give_up(key);
}

void Production::Board::spoil(const ElementKey& key, Error error) {
  const Waking waking(*this);
  const std::lock_guard lock(mutex_);
  if (!trees_.contains(key.tree.value)) return;
  const auto first = std::find_if(finished_.begin(), finished_.end(),
                                  [&](const FinishedElement& finished) { return finished.key == key; });
  if (first != finished_.end()) {
    first->element = std::move(error);
  } else {
    finished_.push_back({key, std::move(error)});
  }
}

void Production::Board::end_batch(TreeId id) {
  const Waking waking(*this);
  const std::lock_guard lock(mutex_);
  if (const auto tree = trees_.find(id.value); tree != trees_.end()) --tree->second.under_way;
}

Production::BatchSink::~BatchSink() {
  fail("");
}

void Production::BatchSink::complete(std::size_t element, Result<Element> made) {
  const ElementKey& key = keys_.at(element);
  if (made.ok()) {
    Status size = check_size(*tree_, key.node, key.kind, made.value());
    if (size.ok()) {
      examine_element(*tree_, key.node, in_host_memory_, made.value());
    } else {
      made = size.error();
    }
  }
  const State before = close(element, State::done);
  if (before == State::failed) return;
  if (before == State::done) {
    board_->spoil(key, Error{name(element) + ": its producer handed it over twice"});
    return;
  }
  board_->finish(key, std::move(made));
  count_closed();
}

bool Production::BatchSink::cancelled(std::size_t element) {
  const ElementKey& key = keys_.at(element);
  if (board_->ask_demand([&](const Demand& demand) { return demand.wanted(key); })) return false;
  const std::lock_guard lock(mutex_);
  if (states_[element] == State::open) states_[element] = State::told;
  return true;
}

void Production::BatchSink::drop(std::size_t element) {
  const State before = close(element, State::done);
  if (before == State::open) {
    board_->finish(keys_[element], Error{name(element) + ": its producer dropped it although it is wanted"});
    count_closed();
  } else if (before == State::told) {
    board_->give_up(keys_[element]);
    count_closed();
  } else if (before == State::done) {
    board_->spoil(keys_[element], Error{name(element) + ": its producer handed it over twice"});
  }
}

void Production::BatchSink::fail(const std::string& why) {
  for (std::size_t i = 0; i < keys_.size(); ++i) {
    const State before = close(i, State::failed);
    if (before != State::open && before != State::told) continue;
    board_->finish(keys_[i], Error{why.empty() ? name(i) + ": its producer never handed it over" : why});
    count_closed();
  }
}

Production::BatchSink::State Production::BatchSink::close(std::size_t element, State state) {
  const std::lock_guard lock(mutex_);
  const State before = states_.at(element);
  if (before == State::open || before == State::told) states_[element] = state;
  return before;
}

void Production::BatchSink::count_closed() {
  {
    const std::lock_guard lock(mutex_);
    if (--open_ > 0) return;
  }
  board_->end_batch(keys_.front().tree);
}

}  // namespace gvx::produce
