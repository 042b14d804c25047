#include "gvx/produce/repeat_producer.h"

#include <algorithm>
#include <vector>

#include "gvx/produce/check_arguments.h"
#include "gvx/store/downsample.h"

namespace gvx::produce {

Result<std::shared_ptr<const RepeatProducer>> RepeatProducer::create(std::shared_ptr<const Producer> volume,
                                                                     std::uint32_t levels) {
  GVX_TRY(check_base(volume, "repeat"));
  const TreeDescription& tree = volume->description();
  constexpr std::uint32_t kFinest = kMaxLevels - 1;
  if (tree.n != 2)
    return Error{"repeat: the volume's tree has " + std::to_string(tree.n) +
                 " children along an axis; only trees of 2 can be repeated"};
  if (levels > kFinest - std::min(tree.max_level, kFinest)) {
    return Error{"repeat: 2^" + std::to_string(levels) + " copies of a tree of " +
                 std::to_string(tree.max_level + 1) + " levels are more than a tree can have"};
  }
  return std::shared_ptr<const RepeatProducer>(new RepeatProducer(std::move(volume), levels));
}

RepeatProducer::RepeatProducer(std::shared_ptr<const Producer> volume, std::uint32_t levels)
    : volume_(std::move(volume)), levels_(levels), description_(volume_->description()) {
  const double copies = nodes_across(2, levels_);
  const Box3d one = description_.extent;
  description_.bounds.reset();
  description_.max_level += levels_;
  description_.tree_to_world = description_.tree_to_world * scaling(Vec3d(copies));
  description_.extent = {one.minimum / copies, Vec3d(1) - (Vec3d(1) - one.maximum) / copies};
  if (description_.bricks > 0) description_.bricks += levels_;
}

/// The node of the volume itself; of levels of copies and below.
NodeKey RepeatProducer::in_volume(const NodeKey& key) const {
  const std::uint32_t level = key.level - levels_;
  const std::uint64_t within = (std::uint64_t{1} << level) - 1;
  return {level, key.x & within, key.y & within, key.z & within};
}

NodeKey RepeatProducer::canonical(const NodeKey& key) const {
  // Above the copies all nodes of a level hold the same.
  if (key.level < levels_) return {key.level, 0, 0, 0};
  NodeKey one = volume_->canonical(in_volume(key));
  one.level += levels_;
  return one;
}

Status RepeatProducer::describe(std::span<const NodeKey> keys, std::span<tree::NodeInfo> infos) const {
  std::vector<NodeKey> in_one(keys.size());
  std::transform(keys.begin(), keys.end(), in_one.begin(),
                 [&](const NodeKey& key) { return key.level < levels_ ? NodeKey{} : in_volume(key); });
  GVX_TRY(volume_->describe(in_one, infos));
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (keys[i].level < levels_) infos[i].terminal = false;
  }
  return {};
}

Status RepeatProducer::produce(const NodeKey& key, std::span<std::byte> voxels) const {
  GVX_TRY(check_brick(description_, voxels));
  if (key.level >= levels_) return volume_->produce(in_volume(key), voxels);
  std::vector<std::byte> root(description_.brick_bytes());
  GVX_TRY(volume_->produce(NodeKey{}, root));
  average(root, key.level, voxels);
  return {};
}

/// A brick of copies, each of `across` voxels along an axis, or several of them in one voxel.
void RepeatProducer::average(std::span<const std::byte> root, std::uint32_t level,
                             std::span<std::byte> voxels) const {
  const auto m = static_cast<std::int64_t>(description_.m), edge = m + 2 * kBrickBorder;
  const std::int64_t copies = std::int64_t(1) << std::min(levels_ - level, 31u);
  const std::int64_t across = std::max<std::int64_t>(m / copies, 1), part = m / across;
  const bool labels = description_.format.content == VoxelContent::labels;
  with_voxel_type(description_.format.type, [&](auto zero) {
    using Voxel = decltype(zero);
    const auto* from = reinterpret_cast<const Voxel*>(root.data());
    auto* to = reinterpret_cast<Voxel*>(voxels.data());
    std::vector<Voxel> one(static_cast<std::size_t>(across * across * across));
    for (std::uint32_t plane = 0; plane < description_.format.planes; ++plane) {
      for (std::int64_t i = 0; i < static_cast<std::int64_t>(one.size()); ++i) {
        const Vec3i first(kBrickBorder + i % across * part, kBrickBorder + i / across % across * part,
                          kBrickBorder + i / across / across * part);
        const auto at = [&](Vec3i p) { return from[(p.z * edge + p.y) * edge + p.x]; };
        double sum = 0, count = 0;  // of the voxels that have a value; of none the mean is NaN
        for (std::int64_t z = 0; z < part; ++z) {
          for (std::int64_t y = 0; y < part; ++y) {
            for (std::int64_t x = 0; x < part; ++x) {
              const Voxel voxel = at(first + Vec3i(x, y, z));
              if (store::is_no_data(voxel)) continue;
              sum += static_cast<double>(voxel);
              ++count;
            }
          }
        }
        Voxel value = store::rounded<Voxel>(sum / count);
        // Classes have no mean.
        if (labels) value = at(first + Vec3i(part / 2));
        one[static_cast<std::size_t>(i)] = value;
      }
      // The border goes on with the next copies.
      const auto wrapped = [&](std::int64_t i) { return (i + m - kBrickBorder) % across; };
      for (std::int64_t z = 0; z < edge; ++z) {
        for (std::int64_t y = 0; y < edge; ++y) {
          for (std::int64_t x = 0; x < edge; ++x) {
            *to++ = one[static_cast<std::size_t>((wrapped(z) * across + wrapped(y)) * across + wrapped(x))];
          }
        }
      }
      from += edge * edge * edge;
    }
  });
}

}  // namespace gvx::produce
