/// \file
/// Demand: which elements clients want, and which are begun next. It knows no threads and no producers;
/// Production has these.
///
/// Clients take turns by stride scheduling (Waldspurger, Weihl, *Stride Scheduling*, 1995): a client's pass
/// grows by 1 / weight for each element that is begun for it, and the client of the least pass is next.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <set>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "gvx/produce/element.h"

namespace gvx::produce {

/// Who wants elements: a viewer, say. No two have the same.
using ClientId = Index<struct ClientTag>;

/// What is ahead, which may be visible soon, is begun only while no visible element waits, anybody's.
enum class Tier : std::uint32_t { visible, ahead };

/// Where an element is: not begun, begun, or made and not yet taken.
enum class Stage : std::uint32_t { waiting, under_way, finished };

class Demand {
 public:
  void add_tree(TreeId tree) { trees_.insert(tree.value); }
  /// Forgets the tree's elements, at whatever stage.
  void remove_tree(TreeId tree);

  /// `weight`, above 0, is the client's share beside those of others that want elements of the same tier.
  ClientId add_client(double weight);
  /// The client wants nothing any more.
  void remove_client(ClientId client);

  /// Replaces what the client wants of a tier. An element that was taken before is made again. Elements of
  /// unknown trees are left out.
  void want(ClientId client, Tier tier, std::span<const ElementKey> most_urgent_first);

  /// How many elements of a tree may begin at once, of so many that wait; 0: none now.
  using Room = std::function<std::size_t(TreeId tree, std::size_t waiting)>;
  /// Begins elements of one tree and kind, the most urgent of the client whose turn it is. Returns none where
  /// nothing waits or producers have no room.
  std::vector<ElementKey> begin(const Room& room);

  /// An element under way is made.
  void finish(const ElementKey& key);
  /// An element under way is not made: it waits again if somebody wants it, before all others.
  void give_up(const ElementKey& key);
  /// An element that is made is taken: it satisfies all clients that wanted it.
  void take(const ElementKey& key);

  /// Does somebody want it, who has not got it?
  bool wanted(const ElementKey& key) const;
  /// Elements at a stage.
  std::size_t count(Stage stage) const { return static_cast<std::size_t>(counts_[std::size_t(stage)]); }
  /// Of the elements that a client wants; one that it wants in both tiers counts twice.
  std::size_t count(ClientId client, Stage stage) const;

 private:
  using Counts = std::array<std::ptrdiff_t, 3>;         // by stage
  using Group = std::pair<std::uint32_t, ElementKind>;  // a tree and a kind

  /// Elements of a group that a client wants of a tier. Those that do not wait any more are passed over.
  struct Queue {
    struct Place {
      std::size_t rank;
      ElementKey key;
    };
    std::vector<Place> places;  // the most urgent last
    std::ptrdiff_t waiting = 0;
  };
  /// What a client wants of a tier.
  struct Line {
    std::uint64_t edition = 0;  // counts the calls of want()
    std::vector<ElementKey> wanted;
    std::map<Group, Queue> queues;
    std::ptrdiff_t waiting = 0;
    double pass = 0;
  };
  struct Client {
    double weight = 1;
    std::array<Line, 2> lines;  // by tier
    Counts counts{};
  };
  /// That a client wants an element.
  struct Wish {
    ClientId client;
    Tier tier = Tier::visible;
    std::uint64_t edition = 0;
  };
  struct Wanted {
    Stage stage = Stage::waiting;
    std::vector<Wish> wishes;
  };
  using Elements = std::unordered_map<ElementKey, Wanted, ElementKeyHash>;

  Line& line_of(const Wish& wish);
  void count(const ElementKey& key, Stage stage, const Wish& wish, std::ptrdiff_t by);
  void move(Elements::iterator element, Stage stage);
  void forget(Elements::iterator element);
  bool add(const Wish& wish, const ElementKey& key);
  void withdraw(const Wish& newest, const ElementKey& key);
  bool waits(const Wish& wish, const ElementKey& key) const;
  const Queue::Place* first(const Wish& wish, Queue& queue) const;
  Queue* most_urgent(const Wish& wish, Line& line, const Room& room) const;

  std::set<std::uint32_t> trees_;
  std::map<std::uint32_t, Client> clients_;
  std::uint32_t next_client_ = 0;
  Elements elements_;
  Counts counts_{};
  std::array<double, 2> pass_{};  // by tier: of the client that was served last
};

}  // namespace gvx::produce
