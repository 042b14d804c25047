/// \file
/// UsageList: which slots of a pool were used when, and so which to give away first. It knows slots, not what
/// is in them. Rays stamp the slots that they touch with the number of their pass; after the pass one
/// order-preserving partition moves the stamped slots behind the others, and that is the whole LRU (GPU Pro
/// text, 3.6.2).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "gvx/exec/buffer.h"
#include "gvx/exec/device.h"
#include "gvx/exec/relaxed.h"

namespace gvx::cache {

/// What kernels stamp.
struct UsageView {
  std::uint32_t* stamps = nullptr;

  /// Any number of threads, the same pass.
  GVX_HD void touch(std::uint32_t slot, std::uint32_t pass) const {
    if (exec::load_relaxed(stamps + slot) != pass) exec::store_relaxed(stamps + slot, pass);
  }
};

class UsageList {
 public:
  /// Slots 0 to `slots`-1; the first `reserved` of them are never given away. All others can be.
  UsageList(const exec::Device& device, std::uint32_t slots, std::uint32_t reserved = 0);

  UsageView view() { return {stamps_.view().data}; }
  std::uint32_t slots() const { return static_cast<std::uint32_t>(stamps_.size()); }
  /// Slots that can be given away.
  std::uint32_t givable() const { return givable_; }

  /// After a pass, whose number is greater than those before: moves the slots that it stamped behind the
  /// others, both in their old order.
  void order_by_use(std::uint32_t pass);

  /// How many slots, at the front of the order, were last stamped before pass `first`.
  std::uint32_t unused_since(std::uint32_t first) const;

  /// Gives the `count` oldest slots to new content: they become the newest, in order, as if the last pass had
  /// stamped them.
  std::vector<std::uint32_t> take_oldest(std::uint32_t count);

  /// The `count` oldest slots can no longer be given away, until restore().
  std::vector<std::uint32_t> withhold(std::uint32_t count);
  /// So many of those that were withheld can be given away again, as the oldest.
  void restore(std::uint32_t count);
  std::uint32_t withheld() const { return static_cast<std::uint32_t>(withheld_.size()); }
  /// In which pass the oldest slot was used last.
  std::uint32_t oldest_pass() const { return stamps_.view()[order_.view()[0]]; }

  /// All slots that can be given away, the oldest first.
  std::span<const std::uint32_t> order() const { return {order_.view().data, givable_}; }

 private:
  exec::Device device_;
  exec::Buffer<std::uint32_t> stamps_, order_, flags_, scratch_;
  std::uint32_t givable_;                // at the front of order_
  std::vector<std::uint32_t> withheld_;  // the last ones first
  std::uint32_t last_pass_ = 0;
};

}  // namespace gvx::cache
