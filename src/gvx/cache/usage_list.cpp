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
      scratch_(device, slots - reserved) {
  std::iota(order_.view().begin(), order_.view().end(), reserved);
}

std::uint32_t UsageList::order_by_use(std::uint32_t pass) {
  exec::for_each(device_, "flag_used", order_.size(),
                 FlagUsed{order_.view(), stamps_.view(), flags_.view(), pass});
  const std::size_t unused = exec::stable_partition(device_, order_.view(), flags_.view(), scratch_.view());
  device_.synchronize();
  return static_cast<std::uint32_t>(unused);
}

std::vector<std::uint32_t> UsageList::take_oldest(std::uint32_t count) {
  GVX_CHECK(count <= givable());
  const auto order = order_.view();
  std::vector<std::uint32_t> taken(order.begin(), order.begin() + count);
  std::rotate(order.begin(), order.begin() + count, order.end());
  return taken;
}

}  // namespace gvx::cache
