/// \file
/// Production makes the elements that clients want, on threads of its own: it merges what they want, begins
/// the most urgent, and keeps what is finished until it is taken. The model is three others': neuroglancer's
/// tiers of visible and prefetched chunks, cesium-native's weights of views, TensorStore's requests that
/// merge.
///
/// An element that several clients want is made once. It stays wanted until it is taken or the last of them
/// wants it no more. What nobody wants is not begun; what is under way is finished all the same.
#pragma once

#include <chrono>
#include <memory>
#include <span>
#include <thread>
#include <vector>

#include "gvx/produce/demand.h"
#include "gvx/produce/producer.h"

namespace gvx::produce {

/// An element that was made, or why it could not be.
struct FinishedElement {
  ElementKey key;
  Result<Element> element;
};

/// All functions may be called from several threads at once.
class Production {
 public:
  using Deadline = std::chrono::steady_clock::time_point;

  explicit Production(int threads);
  /// Waits for calls of Producer::start() to return; what is under way beyond them is not waited for.
  ~Production();
  Production(const Production&) = delete;
  Production& operator=(const Production&) = delete;

  /// From now on, elements of the producer's tree can be wanted.
  TreeId add(std::shared_ptr<const Producer> producer);
  /// None of the tree's elements are begun or finished any more.
  void remove(TreeId tree);

  /// A client's weight, above 0, is its share of the elements begun beside others that want some of the same
  /// tier.
  ClientId add_client(double weight = 1);
  /// The client wants nothing any more.
  void remove_client(ClientId client);

  /// Replaces what a client wants of a tier. What is under way, or finished and not taken, is not begun
  /// again; what was taken is.
  void want(ClientId client, Tier tier, std::span<const ElementKey> most_urgent_first);

  /// What is finished, in the order of finishing, whoever wanted it. Does not wait.
  std::vector<FinishedElement> take_finished();

  /// Waits until something is finished or nothing is left to do, but no longer than until `deadline`.
  void wait_until(Deadline deadline);
  /// The same, until nothing that the client wants is left to do.
  void wait_until(ClientId client, Deadline deadline);

  /// Is nothing that the client wants waiting, being made, or finished and not taken?
  bool idle(ClientId client) const;

  /// How long threads have been starting batches, all of them together; producers that do not override
  /// start() make them meanwhile.
  double making_milliseconds() const;

 private:
  class Board;
  class BatchSink;
  void work();

  std::shared_ptr<Board> board_;
  std::vector<std::thread> threads_;
};

}  // namespace gvx::produce
