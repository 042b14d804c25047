#include "gvx/produce/demand.h"

#include <algorithm>
#include <utility>

namespace gvx::produce {

ClientId Demand::add_client(double weight) {
  GVX_CHECK(weight > 0);
  const ClientId id(next_client_++);
  clients_[id.value].weight = weight;
  return id;
}

void Demand::remove_client(ClientId client) {
  want(client, Tier::visible, {});
  want(client, Tier::ahead, {});
  clients_.erase(client.value);
}

void Demand::remove_tree(TreeId tree) {
  trees_.erase(tree.value);
  for (auto element = elements_.begin(); element != elements_.end();) {
    const auto here = element++;
    if (here->first.tree == tree) forget(here);
  }
  for (auto& [id, client] : clients_) {
    for (Line& line : client.lines) {
      std::erase_if(line.queues, [&](const auto& queue) { return queue.first.first == tree.value; });
    }
  }
}

void Demand::want(ClientId client, Tier tier, std::span<const ElementKey> most_urgent_first) {
  GVX_CHECK(clients_.contains(client.value));
  Wish wish{client, tier, 0};
  Line& line = line_of(wish);
  wish.edition = ++line.edition;
  for (auto& [group, queue] : line.queues) queue.places.clear();
  std::vector<ElementKey> wanted;
  for (const ElementKey& key : most_urgent_first) {
    if (!trees_.contains(key.tree.value) || !add(wish, key)) continue;
    line.queues[{key.tree.value, key.kind}].places.push_back({wanted.size(), key});
    wanted.push_back(key);
  }
  for (auto& [group, queue] : line.queues) std::reverse(queue.places.begin(), queue.places.end());
  for (const ElementKey& key : std::exchange(line.wanted, std::move(wanted))) withdraw(wish, key);
}

std::vector<ElementKey> Demand::begin(const Room& room) {
  const auto waits_in = [&](std::size_t tier) {
    return std::any_of(clients_.begin(), clients_.end(),
                       [&](const auto& client) { return client.second.lines[tier].waiting > 0; });
  };
  const std::size_t tier = waits_in(0) ? 0 : 1;
  Queue* next = nullptr;
  Client* served = nullptr;
  Wish wish;
  for (auto& [id, client] : clients_) {
    Line& line = client.lines[tier];
    if (line.waiting == 0 || (served != nullptr && line.pass >= served->lines[tier].pass)) continue;
    const Wish of_client{ClientId(id), Tier(tier), 0};
    if (Queue* queue = most_urgent(of_client, line, room); queue != nullptr) {
      next = queue;
      served = &client;
      wish = of_client;
    }
  }
  std::vector<ElementKey> begun;
  if (served == nullptr) return begun;
  const TreeId tree = next->places.back().key.tree;
  const std::size_t most = room(tree, static_cast<std::size_t>(next->waiting));
  while (begun.size() < most && first(wish, *next) != nullptr) {
    begun.push_back(next->places.back().key);
    next->places.pop_back();
    move(elements_.find(begun.back()), Stage::under_way);
  }
  double& pass = served->lines[tier].pass;
  pass_[tier] = pass;
  pass += static_cast<double>(begun.size()) / served->weight;
  return begun;
}

void Demand::finish(const ElementKey& key) {
  if (const auto element = elements_.find(key); element != elements_.end()) move(element, Stage::finished);
}

void Demand::give_up(const ElementKey& key) {
  const auto element = elements_.find(key);
  if (element == elements_.end()) return;
  if (element->second.wishes.empty()) {
    forget(element);
    return;
  }
  move(element, Stage::waiting);
  for (const Wish& wish : element->second.wishes) {
    line_of(wish).queues[{key.tree.value, key.kind}].places.push_back({0, key});
  }
}

void Demand::take(const ElementKey& key) {
  const auto element = elements_.find(key);
  if (element != elements_.end() && element->second.stage == Stage::finished) forget(element);
}

bool Demand::wanted(const ElementKey& key) const {
  const auto element = elements_.find(key);
  return element != elements_.end() && !element->second.wishes.empty();
}

std::size_t Demand::count(ClientId client, Stage stage) const {
  const auto found = clients_.find(client.value);
  return found == clients_.end() ? 0 : static_cast<std::size_t>(found->second.counts[std::size_t(stage)]);
}

Demand::Line& Demand::line_of(const Wish& wish) {
  return clients_.at(wish.client.value).lines[std::size_t(wish.tier)];
}

/// Counts an element for one who wants it.
void Demand::count(const ElementKey& key, Stage stage, const Wish& wish, std::ptrdiff_t by) {
  clients_.at(wish.client.value).counts[std::size_t(stage)] += by;
  if (stage != Stage::waiting) return;
  Line& line = line_of(wish);
  // Who had nothing that waited has saved no turns meanwhile.
  if (line.waiting == 0) line.pass = std::max(line.pass, pass_[std::size_t(wish.tier)]);
  line.waiting += by;
  line.queues[{key.tree.value, key.kind}].waiting += by;
}

void Demand::move(Elements::iterator element, Stage stage) {
  auto& [key, wanted] = *element;
  --counts_[std::size_t(wanted.stage)];
  ++counts_[std::size_t(stage)];
  for (const Wish& wish : wanted.wishes) {
    count(key, wanted.stage, wish, -1);
    count(key, stage, wish, 1);
  }
  wanted.stage = stage;
}

void Demand::forget(Elements::iterator element) {
  const auto& [key, wanted] = *element;
  --counts_[std::size_t(wanted.stage)];
  for (const Wish& wish : wanted.wishes) count(key, wanted.stage, wish, -1);
  elements_.erase(element);
}

/// Returns whether the wish is new in its edition.
bool Demand::add(const Wish& wish, const ElementKey& key) {
  const auto [element, is_new] = elements_.try_emplace(key);
  Wanted& wanted = element->second;
  if (is_new) ++counts_[std::size_t(wanted.stage)];
  for (Wish& other : wanted.wishes) {
    if (other.client == wish.client && other.tier == wish.tier)
      return std::exchange(other.edition, wish.edition) != wish.edition;
  }
  wanted.wishes.push_back(wish);
  count(key, wanted.stage, wish, 1);
  return true;
}

/// Removes the wish of an older edition. Nothing is left of an element that has not begun and nobody wants.
void Demand::withdraw(const Wish& newest, const ElementKey& key) {
  const auto element = elements_.find(key);
  if (element == elements_.end()) return;
  Wanted& wanted = element->second;
  const auto gone = std::erase_if(wanted.wishes, [&](const Wish& wish) {
    return wish.client == newest.client && wish.tier == newest.tier && wish.edition != newest.edition;
  });
  if (gone == 0) return;
  count(key, wanted.stage, newest, -1);
  if (wanted.wishes.empty() && wanted.stage == Stage::waiting) forget(element);
}

bool Demand::waits(const Wish& wish, const ElementKey& key) const {
  const auto element = elements_.find(key);
  if (element == elements_.end() || element->second.stage != Stage::waiting) return false;
  const std::vector<Wish>& wishes = element->second.wishes;
  return std::any_of(wishes.begin(), wishes.end(), [&](const Wish& other) {
    return other.client == wish.client && other.tier == wish.tier;
  });
}

/// The most urgent element of a queue that still waits.
const Demand::Queue::Place* Demand::first(const Wish& wish, Queue& queue) const {
  while (!queue.places.empty() && !waits(wish, queue.places.back().key)) queue.places.pop_back();
  return queue.places.empty() ? nullptr : &queue.places.back();
}

/// The queue of a line with the most urgent element, of those whose producers have room.
Demand::Queue* Demand::most_urgent(const Wish& wish, Line& line, const Room& room) const {
  Queue* best = nullptr;
  for (auto& [group, queue] : line.queues) {
    if (queue.waiting == 0 || room(TreeId(group.first), static_cast<std::size_t>(queue.waiting)) == 0)
      continue;
    const Queue::Place* place = first(wish, queue);
    if (place != nullptr && (best == nullptr || place->rank < best->places.back().rank)) best = &queue;
  }
  return best;
}

}  // namespace gvx::produce
