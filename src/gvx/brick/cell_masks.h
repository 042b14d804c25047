/// \file
/// CellMasks: 64 bits for each slot of a brick pool that say which of its cells can be seen. They are found
/// by whoever first needs them, and hold until the brick or the transfer function is another. Each viewer has
/// its own. On a CPU.
#pragma once

#include <cstdint>

#include "gvx/core/index.h"
#include "gvx/exec/buffer.h"
#include "gvx/exec/device.h"

namespace gvx::brick {

/// For any number of threads.
struct CellMaskView {
  std::uint64_t* masks = nullptr;
  std::uint32_t* known = nullptr;  ///< the function that a mask is of
  std::uint32_t function = 0;

  /// The mask of a slot; find() finds it if it is not known.
  template <typename Find>
  std::uint64_t of(BrickIndex slot, const Find& find) const {
    if (__atomic_load_n(&known[slot.value], __ATOMIC_ACQUIRE) == function) {
      return __atomic_load_n(&masks[slot.value], __ATOMIC_RELAXED);
    }
    const std::uint64_t mask = find();
    __atomic_store_n(&masks[slot.value], mask, __ATOMIC_RELAXED);
    __atomic_store_n(&known[slot.value], function, __ATOMIC_RELEASE);
    return mask;
  }
};

class CellMasks {
 public:
  CellMasks(const exec::Device& device, std::uint32_t slots) : masks_(device, slots), known_(device, slots) {}

  CellMaskView view() { return {masks_.view().data, known_.view().data, function_}; }
  void forget(BrickIndex slot) { known_.view()[slot.value] = 0; }
  void forget_all() { ++function_; }

 private:
  exec::Buffer<std::uint64_t> masks_;
  exec::Buffer<std::uint32_t> known_;
  std::uint32_t function_ = 1;
};

}  // namespace gvx::brick
