#include "gvx/engine/surface_residency.h"

#include "gvx/core/result.h"
#include "gvx/surface/stored_surface.h"

namespace gvx::engine {

using produce::ElementKey;
using produce::ElementKind;

const std::vector<std::byte>* SurfaceResidency::use(const ElementKey& key) {
  const auto found = elements_.find(key);
  if (found == elements_.end()) return nullptr;
  Kept& kept = found->second;
  if (kept.pass != pass_) {
    kept.pass = pass_;
    order_.splice(order_.end(), order_, kept.place);
  }
  return kept.bytes.get();
}

const surface::SurfaceNode* SurfaceResidency::node(std::uint32_t level, std::uint32_t place) {
  const std::uint32_t page = place / surface::kPageNodes;
  const auto* const bytes = use({tree_, {level, page, 0, 0}, ElementKind::surface_nodes});
  if (bytes == nullptr) return nullptr;
  return reinterpret_cast<const surface::SurfaceNode*>(bytes->data()) + place % surface::kPageNodes;
}

const std::byte* SurfaceResidency::piece(std::uint32_t level, std::uint32_t place, surface::Piece piece) {
  const auto* const bytes = use({tree_, {level, place, 0, 0}, surface::kind_of(piece)});
  return bytes != nullptr ? bytes->data() : nullptr;
}

void SurfaceResidency::begin_pass(std::uint32_t pass, std::uint32_t in_use_since) {
  pass_ = pass;
  in_use_since_ = in_use_since;
}

ElementKey SurfaceResidency::key_of(const surface::LackingElement& lacking) const {
  return {tree_,
          {lacking.level, lacking.place, 0, 0},
          lacking.page ? ElementKind::surface_nodes : surface::kind_of(lacking.piece)};
}

void SurfaceResidency::put(const ElementKey& key, std::shared_ptr<const std::vector<std::byte>> bytes) {
  if (elements_.contains(key)) return;
  bytes_ += bytes->size() + kOfEach;
  const auto place = order_.insert(order_.end(), key);
  elements_.emplace(key, Kept{std::move(bytes), pass_, place});
}

bool SurfaceResidency::may_evict(Eviction eviction) const {
  return !order_.empty() && (eviction == Eviction::any || oldest_pass() < in_use_since_);
}

std::uint64_t SurfaceResidency::evictable(Eviction eviction) const {
  if (eviction == Eviction::any) return bytes_;
  std::uint64_t bytes = 0;
  for (const ElementKey& key : order_) {
    const Kept& kept = elements_.at(key);
    if (kept.pass >= in_use_since_) break;
    bytes += kept.bytes->size() + kOfEach;
  }
  return bytes;
}

void SurfaceResidency::evict_oldest() {
  GVX_CHECK(!order_.empty());
  const auto oldest = elements_.find(order_.front());
  bytes_ -= oldest->second.bytes->size() + kOfEach;
  elements_.erase(oldest);
  order_.pop_front();
  ++evicted_;
}

}  // namespace gvx::engine
