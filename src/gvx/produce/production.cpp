#include "gvx/produce/production.h"

#include <exception>
#include <new>
#include <string>
#include <utility>

#include "gvx/produce/production_board.h"

namespace gvx::produce {

Production::Production(int threads) : board_(std::make_shared<Board>(threads)) {
  GVX_CHECK(threads > 0);
  for (int i = 0; i < threads; ++i) threads_.emplace_back([this] { work(); });
}

Production::~Production() {
  board_->stop();
  for (std::thread& thread : threads_) thread.join();
}

TreeId Production::add(std::shared_ptr<const Producer> producer) {
  return board_->add(std::move(producer));
}

void Production::remove(TreeId tree) {
  board_->remove(tree);
}

ClientId Production::add_client(double weight) {
  return board_->change_demand([&](Demand& demand) { return demand.add_client(weight); });
}

void Production::remove_client(ClientId client) {
  board_->change_demand([&](Demand& demand) { demand.remove_client(client); });
}

void Production::want(ClientId client, Tier tier, std::span<const ElementKey> most_urgent_first) {
  board_->change_demand([&](Demand& demand) { demand.want(client, tier, most_urgent_first); });
}

std::vector<FinishedElement> Production::take_finished() {
  return board_->take_finished();
}

void Production::wait_until(Deadline deadline) {
  board_->wait_until(std::nullopt, deadline);
}

void Production::wait_until(ClientId client, Deadline deadline) {
  board_->wait_until(client, deadline);
}

bool Production::idle(ClientId client) const {
  return board_->ask_demand([&](const Demand& demand) {
    return demand.count(client, Stage::waiting) + demand.count(client, Stage::under_way) +
               demand.count(client, Stage::finished) ==
           0;
  });
}

double Production::making_milliseconds() const {
  return board_->making_time.milliseconds();
}

void Production::work() {
  while (const auto batch = board_->next()) {
    const TimeSum::Span making(board_->making_time);
    const auto sink = std::make_shared<BatchSink>(board_, *batch);
    std::vector<NodeKey> nodes;
    for (const ElementKey& key : batch->keys) nodes.push_back(key.node);
    try {
      batch->producer->start({batch->keys.front().kind, nodes}, sink);
    } catch (const std::bad_alloc&) {
      sink->fail("out of memory");
    } catch (const std::exception& error) {
      sink->fail(std::string("a producer failed: ") + error.what());
    } catch (...) {
      sink->fail("a producer failed and did not say why");
    }
  }
}

}  // namespace gvx::produce
