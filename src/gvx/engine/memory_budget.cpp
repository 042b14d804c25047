#include "gvx/engine/memory_budget.h"

#include <algorithm>

namespace gvx::engine {
namespace {

/// Of a volume's slots those that hold bricks, or may.
std::uint64_t usable(const Residency& residency) {
  return residency.bricks().slots() - residency.withheld_bricks();
}

std::uint64_t bytes_of(const Volume& volume) {
  return usable(volume.residency()) * volume.residency().bricks().brick_bytes();
}

}  // namespace

void MemoryBudget::add(Volume* volume) {
  Residency& residency = volume->residency();
  const std::uint64_t fit = left() / residency.bricks().brick_bytes();
  const std::uint64_t slots = residency.bricks().slots();
  if (fit < slots) residency.withhold_bricks(static_cast<std::uint32_t>(slots - fit));
  volumes_.push_back(volume);
}

void MemoryBudget::remove(const Volume* volume) {
  std::erase(volumes_, volume);
}

std::uint64_t MemoryBudget::left() const {
  std::uint64_t used = 0;
  for (const Volume* volume : volumes_) used += bytes_of(*volume);
  return bytes_ - std::min(bytes_, used);
}

/// Of the others that can give a brick away, the one whose oldest was not used for the longest time.
Volume* MemoryBudget::with_oldest(const Volume& but, Eviction eviction) const {
  Volume* oldest = nullptr;
  for (Volume* volume : volumes_) {
    if (volume == &but || volume->residency().room(eviction).bricks == 0) continue;
    const bool older = oldest == nullptr ||
                       volume->residency().oldest_brick_pass() < oldest->residency().oldest_brick_pass();
    if (older) oldest = volume;
  }
  return oldest;
}

void MemoryBudget::make_room(Volume& volume, std::size_t wanted, Eviction eviction) {
  Residency& residency = volume.residency();
  const std::uint64_t brick = residency.bricks().brick_bytes();
  while (residency.withheld_bricks() > 0) {
    const std::size_t room = residency.room(eviction).bricks;
    if (room >= wanted) return;
    const auto lack = std::min<std::uint64_t>(wanted - room, residency.withheld_bricks());
    const std::uint64_t bytes_left = left();
    const std::uint64_t fit = std::min(lack, bytes_left / brick);
    if (fit > 0) {
      residency.restore_bricks(static_cast<std::uint32_t>(fit));
      continue;
    }
    Volume* giver = with_oldest(volume, eviction);
    if (giver == nullptr) return;
    // Some at a time: then another's may be the oldest.
    constexpr std::uint64_t kMostAtOnce = 64;
    Residency& from = giver->residency();
    const std::uint64_t bytes = lack * brick - std::min(bytes_left, lack * brick);
    const std::uint64_t count = (bytes + from.bricks().brick_bytes() - 1) / from.bricks().brick_bytes();
    from.withhold_bricks(static_cast<std::uint32_t>(
        std::min({count, kMostAtOnce, std::uint64_t(from.room(eviction).bricks)})));
  }
}

}  // namespace gvx::engine
