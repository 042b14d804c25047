/// \file
/// WorkBar: shows how far the opening of a scene or the building of a store is.
#pragma once

#include <optional>
#include <string>
#include <utility>

#include "gvx/open/options.h"
#include "progress.h"

namespace gvx::app {

/// A bar for each piece of the work in turn. To be called from one thread.
class WorkBar {
 public:
  /// `title` says what is done as a whole; empty: what the piece is called says it.
  WorkBar(std::string title, bool quiet) : title_(std::move(title)), quiet_(quiet) {}

  void show(const open::Work& work);
  /// Takes the bar away.
  void clear() { progress_.reset(); }

 private:
  std::string title_, shown_;
  bool quiet_;
  std::optional<Progress> progress_;
};

}  // namespace gvx::app
