#include "gvx/cache/usage_list.h"

#include <algorithm>
#include <numeric>

#include "gvx/exec/algorithms.h"
#include "gvx/exec/for_each.h"

namespace gvx::cache {
namespace {

struct FlagUsed {
  exec::BufferView<const std::uint32_t> order, stamps;
  exec::BufferView<std::uint32_t> flags;
  std::uint32_t pass;
  GVX_HD void operator()(std::size_t i) const { flags[i] = stamps[order[i]] == pass ? 1 : 0; }
};

}  // namespace

UsageList::UsageList(const exec::Device& device, std::uint32_t slots, std::uint32_t reserved)
    : device_(device),
      stamps_(device, slots),
      order_(device, slots - reserved),
      flags_(device, slots - reserved),
      scratch_(device, slots - reserved),
      givable_(slots - reserved) {
  std::iota(order_.view().begin(), order_.view().end(), reserved);
}

void UsageList::order_by_use(std::uint32_t pass) {
  GVX_CHECK(pass >= last_pass_);
  last_pass_ = pass;
  const exec::BufferView<std::uint32_t> order{order_.view().data, givable_};
  exec::for_each(device_, "flag_used", givable_, FlagUsed{order, stamps_.view(), flags_.view(), pass});
  exec::stable_partition(device_, order, {flags_.view().data, givable_}, scratch_.view());
  device_.synchronize();
}

std::uint32_t UsageList::unused_since(std::uint32_t first) const {
  const std::span<const std::uint32_t> order = this->order();
  const auto stamps = stamps_.view();
  const auto used = std::partition_point(order.begin(), order.end(),
                                         [&](std::uint32_t slot) { return stamps[slot] < first; });
  return static_cast<std::uint32_t>(used - order.begin());
}

std::vector<std::uint32_t> UsageList::take_oldest(std::uint32_t count) {
  GVX_CHECK(count <= givable());
  const auto order = order_.view();
  std::vector<std::uint32_t> taken(order.begin(), order.begin() + count);
  for (const std::uint32_t slot : taken) stamps_.view()[slot] = last_pass_;
  std::rotate(order.begin(), order.begin() + count, order.begin() + givable_);
  return taken;
}

std::vector<std::uint32_t> UsageList::withhold(std::uint32_t count) {
  GVX_CHECK(count <= givable());
  const auto order = order_.view();
  std::vector<std::uint32_t> taken(order.begin(), order.begin() + count);
  std::copy(order.begin() + count, order.begin() + givable_, order.begin());
  givable_ -= count;
  withheld_.insert(withheld_.end(), taken.rbegin(), taken.rend());
  return taken;
}

void UsageList::restore(std::uint32_t count) {
  GVX_CHECK(count <= withheld());
  const auto order = order_.view();
  std::copy_backward(order.begin(), order.begin() + givable_, order.begin() + givable_ + count);
  for (std::uint32_t i = 0; i < count; ++i) {
    order[i] = withheld_.back();
    withheld_.pop_back();
    stamps_.view()[order[i]] = 0;
  }
  givable_ += count;
}

}  // namespace gvx::cache
