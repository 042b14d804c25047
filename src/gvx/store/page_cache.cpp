#include "gvx/store/page_cache.h"

namespace gvx::store {
std::size_t PageCache::Hash::operator()(const PageKey& key) const {
  std::uint64_t h = key.ref.offset ^ std::uint64_t{key.ref.checksum} << 32 ^ key.ref.bytes;
  h = (h ^ h >> 32) * 0x9e3779b97f4a7c15ull + (key.of_records ? 1 : 0);
  return static_cast<std::size_t>(h ^ h >> 29);
}

std::size_t PageCache::bytes() const {
  const std::lock_guard lock(mutex_);
  return bytes_;
}

void PageCache::finish_load(const PageKey& key, const Result<Page>& page) {
  const std::lock_guard lock(mutex_);
  const auto slot = slots_.find(key);
  if (!page.ok()) {
    order_.erase(slot->second.place);
    slots_.erase(slot);
    return;
  }
  slot->second.bytes = page.value()->size() + kOfEach;
  bytes_ += slot->second.bytes;
  drop_oldest();
}

void PageCache::set_bound(std::size_t most_bytes) {
  const std::lock_guard lock(mutex_);
  most_bytes_ = most_bytes;
  drop_oldest();
}

void PageCache::drop_oldest() {
  for (auto last = order_.end(); bytes_ > most_bytes_ && last != order_.begin();) {
    --last;
    const auto oldest = slots_.find(*last);
    if (oldest->second.bytes == 0) continue;
    bytes_ -= oldest->second.bytes;
    slots_.erase(oldest);
    last = order_.erase(last);
  }
}

}  // namespace gvx::store
