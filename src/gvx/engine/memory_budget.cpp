#include "gvx/engine/memory_budget.h"

#include <algorithm>
#include <vector>

namespace gvx::engine {
namespace {

/// Of a volume's slots those that hold bricks, or may.
std::uint64_t usable(const Residency& residency) {
  return residency.bricks().slots() - residency.withheld_bricks();
}

std::uint64_t brick_bytes_of(const Volume& volume) {
  return usable(volume.residency()) * volume.residency().bricks().brick_bytes();
}

}  // namespace

void MemoryBudget::add(Volume* volume) {
  const bool first = shares_.empty();
  shares_.push_back({volume, volume->residency().nodes().bytes(), volume->producer()->wanted_memory()});
  // Its bricks get what is left when all producers have their parts.
  const std::uint64_t own_bricks = brick_bytes_of(*volume);
  share_out(bytes_);
  const std::uint64_t others = bytes_used() - own_bricks;
  // The first volume gets two bricks in any case, be it beyond the bytes.
  constexpr std::uint64_t kFewest = 2;
  const brick::BrickPool& bricks = volume->residency().bricks();
  const std::uint64_t fit =
      std::max((bytes_ - std::min(bytes_, others)) / bricks.brick_bytes(), first ? kFewest : 0);
  if (fit < bricks.slots()) {
    volume->residency().withhold_bricks(static_cast<std::uint32_t>(bricks.slots() - fit));
  }
}

void MemoryBudget::remove(const Volume* volume) {
  std::erase_if(shares_, [&](const Share& share) { return share.volume == volume; });
  share_out(bytes_left());
}

/// Producers get an eighth of the bytes, those that want little first: what they leave is for the others. By
/// no more than `most_growth` does what they have together grow.
void MemoryBudget::share_out(std::uint64_t most_growth) {
  constexpr std::uint64_t kPart = 8;
  std::vector<Share*> by_want;
  for (Share& share : shares_) by_want.push_back(&share);
  std::sort(by_want.begin(), by_want.end(),
            [](const Share* a, const Share* b) { return a->producer_wants < b->producer_wants; });
  std::uint64_t left = bytes_ / kPart;
  for (std::size_t i = 0; i < by_want.size(); ++i) {
    Share& share = *by_want[i];
    const std::uint64_t part = std::min(share.producer_wants, left / (by_want.size() - i));
    const std::uint64_t growth = std::min(part - std::min(part, share.of_producer), most_growth);
    share.of_producer = std::min(part, share.of_producer + growth);
    most_growth -= growth;
    left -= share.of_producer;
    share.volume->producer()->keep_at_most(share.of_producer);
  }
}

std::uint64_t MemoryBudget::bytes_used() const {
  std::uint64_t used = 0;
  for (const Share& share : shares_) {
    used += share.of_nodes + share.of_producer + brick_bytes_of(*share.volume);
  }
  for (const Surface* surface : surfaces_) used += surface->residency().bytes();
  return used;
}

/// Of the others that can give a brick away, the one whose oldest was not used for the longest time.
Volume* MemoryBudget::with_oldest(const Volume* but, Eviction eviction) const {
  Volume* oldest = nullptr;
  for (const Share& share : shares_) {
    Volume* const volume = share.volume;
    if (volume == but || volume->residency().room(eviction).bricks == 0) continue;
    const bool older =
        oldest == nullptr || volume->residency().brick_pass(0) < oldest->residency().brick_pass(0);
    if (older) oldest = volume;
  }
  return oldest;
}

Surface* MemoryBudget::surface_with_oldest(Eviction eviction) const {
  Surface* oldest = nullptr;
  for (Surface* surface : surfaces_) {
    if (!surface->residency().may_evict(eviction)) continue;
    const bool older =
        oldest == nullptr || surface->residency().oldest_pass() < oldest->residency().oldest_pass();
    if (older) oldest = surface;
  }
  return oldest;
}

bool MemoryBudget::make_room(std::uint64_t wanted_bytes, Eviction eviction) {
  if (wanted_bytes > bytes_) return false;
  while (bytes_used() + wanted_bytes > bytes_) {
    Surface* const surface = surface_with_oldest(eviction);
    Volume* const volume = with_oldest(nullptr, eviction);
    if (surface == nullptr && volume == nullptr) return false;
    const bool of_volume =
        surface == nullptr ||
        (volume != nullptr && volume->residency().brick_pass(0) <= surface->residency().oldest_pass());
    if (!of_volume) {
      surface->residency().evict_oldest();
      continue;
    }
    Residency& from = volume->residency();
    const std::uint64_t lack = bytes_used() + wanted_bytes - bytes_, brick = from.bricks().brick_bytes();
    const std::uint64_t most = std::max<std::uint64_t>(from.free_bricks(), 1);
    from.withhold_bricks(static_cast<std::uint32_t>(
        std::min({(lack + brick - 1) / brick, most, std::uint64_t(from.room(eviction).bricks)})));
  }
  return true;
}

void MemoryBudget::make_room(Volume& volume, std::size_t wanted, Eviction eviction) {
  Residency& residency = volume.residency();
  const std::uint64_t brick = residency.bricks().brick_bytes();
  while (residency.withheld_bricks() > 0) {
    const std::uint64_t empty = residency.free_bricks();
    if (empty >= wanted) return;
    const std::uint64_t lack = std::min<std::uint64_t>(wanted - empty, residency.withheld_bricks());
    if (const std::uint64_t fit = std::min(lack, bytes_left() / brick); fit > 0) {
      residency.restore_bricks(static_cast<std::uint32_t>(fit));
      continue;
    }
    Volume* giver = with_oldest(&volume, eviction);
    const bool own_may_go = residency.room(eviction).bricks > empty;
    if (Surface* const surface = surface_with_oldest(eviction);
        surface != nullptr &&
        (giver == nullptr || surface->residency().oldest_pass() < giver->residency().brick_pass(0))) {
      const bool own_is_older = own_may_go && residency.brick_pass(static_cast<std::uint32_t>(empty)) <=
                                                  surface->residency().oldest_pass();
      if (own_is_older) return;
      surface->residency().evict_oldest();
      continue;
    }
    if (giver == nullptr) return;
    Residency& from = giver->residency();
    if (own_may_go && residency.brick_pass(static_cast<std::uint32_t>(empty)) <= from.brick_pass(0)) return;
    // Of bricks some at a time: then another's may be the oldest.
    constexpr std::uint64_t kMostAtOnce = 16;
    const std::uint64_t needed = bytes_used() + lack * brick, bytes = needed - std::min(needed, bytes_);
    const std::uint64_t count = (bytes + from.bricks().brick_bytes() - 1) / from.bricks().brick_bytes();
    const std::uint64_t most = std::max(from.free_bricks(), kMostAtOnce);
    from.withhold_bricks(
        static_cast<std::uint32_t>(std::min({count, most, std::uint64_t(from.room(eviction).bricks)})));
  }
}

}  // namespace gvx::engine
