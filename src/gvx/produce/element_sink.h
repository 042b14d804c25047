/// \file
/// ElementSink: where a producer hands over the elements of a batch, each when it is made.
#pragma once

#include <cstddef>
#include <span>

#include "gvx/produce/element.h"

namespace gvx::produce {

/// Elements of one kind to make, the most urgent first.
struct ElementBatch {
  ElementKind kind = ElementKind::brick;
  std::span<const NodeKey> nodes;  ///< canonical
};

/// Takes what comes of the elements of one batch. Each element is completed or dropped exactly once, in any
/// order, from any thread; what the last owner of the sink has not handed over becomes an error. `element` is
/// an element's place in the batch.
class ElementSink {
 public:
  virtual ~ElementSink() = default;

  /// Hands over an element, or says why it cannot be made.
  virtual void complete(std::size_t element, Result<Element> made) = 0;

  /// Does nobody want the element any more? It may be completed all the same.
  virtual bool cancelled(std::size_t element) = 0;

  /// Gives up an element of which cancelled() has been true. If somebody wants it again by now, it is begun
  /// again.
  virtual void drop(std::size_t element) = 0;
};

}  // namespace gvx::produce
