/// \file
/// What is found out about an element once its producer has handed it over.
#pragma once

#include "gvx/produce/element.h"
#include "gvx/produce/producer.h"

namespace gvx::produce {

/// Is what a tree's producer made of the size that it must have? An error that names the element if not.
Status check_size(const TreeDescription& tree, const NodeKey& node, ElementKind kind, const Element& made);

/// Finds the ranges of a brick in the host's memory, and whether it has one value, unless the tree's ranges
/// are exact. A brick of one value is a constant only where nothing is below it: the flat mean of a sub-tree
/// says nothing of the sub-tree. Elsewhere the producer's `constant` is removed.
void examine_element(const TreeDescription& tree, const NodeKey& node, bool in_host_memory, Element& brick);

/// Makes one element while the calling thread waits, and examines it; what the producer throws becomes an
/// error.
Result<Element> make_element(const Producer& producer, const NodeKey& node, ElementKind kind);

}  // namespace gvx::produce
