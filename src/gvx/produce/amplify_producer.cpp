#include "gvx/produce/amplify_producer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "gvx/produce/check_arguments.h"
#include "gvx/produce/stored_value.h"

namespace gvx::produce {
namespace {

/// What a value v of a range becomes with this noise.
double amplified(double v, ValueRange range, double noise, double strength) {
  const double width = range.maximum - range.minimum;
  return v + strength * width * AddedNoise::share_at(v, range) * noise;
}

template <typename Voxel>
Voxel as_voxel(double v) {
  if constexpr (std::is_same_v<Voxel, float>) {
    return static_cast<float>(v);
  } else {
    return static_cast<Voxel>(
        std::clamp(std::floor(v + 0.5), 0.0, double(std::numeric_limits<Voxel>::max())));
  }
}

}  // namespace

AddedNoise amplification(const TreeDescription& volume, const AmplifyOptions& options) {
  const double voxel = 1 / (nodes_across(static_cast<int>(volume.n), volume.max_level) * volume.m);
  // Octaves until the finest voxels resolve no more.
  const double octaves = std::log2(options.wavelength) + options.levels * std::log2(volume.n);
  const ValueRange values = volume.ranges.channel[0];
  return {.noise = {.octaves = static_cast<std::uint32_t>(std::clamp(std::ceil(octaves), 1.0, 32.0)),
                    .wavelength = options.wavelength * voxel,
                    .gain = options.gain,
                    .seed = options.seed},
          .strength = options.strength * (double(values.maximum) - values.minimum),
          .fades = values};
}

Result<std::shared_ptr<const AmplifyProducer>> AmplifyProducer::create(std::shared_ptr<const Producer> volume,
                                                                       const AmplifyOptions& options) {
  GVX_TRY(check_base(volume, "amplify"));
  const TreeDescription& tree = volume->description();
  if (!(options.wavelength > 0) || !(options.gain >= 0) || !std::isfinite(options.strength)) {
    return Error{"amplify: expected a wavelength above 0, a gain of 0 or more, and a finite strength"};
  }
  if (tree.format.content != VoxelContent::scalar) {
    return Error{std::string("amplify: expected scalars, found ") + content_name(tree.format.content)};
  }
  constexpr std::uint32_t kMost = 32;
  if (nodes_across(static_cast<int>(tree.n), tree.max_level + std::min(options.levels, kMost)) > 0x1p31) {
    return Error{"amplify: more levels than a tree can have"};
  }
  return std::shared_ptr<const AmplifyProducer>(new AmplifyProducer(std::move(volume), options));
}

AmplifyProducer::AmplifyProducer(std::shared_ptr<const Producer> volume, const AmplifyOptions& options)
    : volume_(std::move(volume)),
      finest_(volume_->description().max_level),
      options_(options),
      description_(volume_->description()) {
  const AddedNoise noise = amplification(description_, options_);
  noise_ = noise.noise;
  description_.beyond_ranges += static_cast<float>(noise.most());
  description_.max_level += options_.levels;
  description_.bricks = 0;
  description_.exact_ranges = false;
}

NodeKey AmplifyProducer::in_volume(const NodeKey& key) const {
  NodeKey above = key;
  while (above.level > finest_) above = parent(above, static_cast<int>(description_.n));
  return volume_->canonical(above);
}

Status AmplifyProducer::describe(std::span<const NodeKey> keys, std::span<tree::NodeInfo> infos) const {
  std::vector<NodeKey> above(keys.size());
  std::transform(keys.begin(), keys.end(), above.begin(), [&](const NodeKey& key) { return in_volume(key); });
  GVX_TRY(volume_->describe(above, infos));
  for (std::size_t i = 0; i < keys.size(); ++i) {
    tree::NodeInfo& info = infos[i];
    if (info.ranges.constant()) continue;
    info.terminal = keys[i].level == description_.max_level;
    const NodeBounds node(keys[i], description_.n, description_.m);
    // For every footprint there is, so that the bounds of a node hold those below.
    const noise::Interval noise = noise_.bounds(node.box, std::numeric_limits<double>::max());
    for (std::uint32_t c = 0; c < description_.format.channels(); ++c) {
      ValueRange& range = info.ranges.channel[c];
      const ValueRange all = description_.ranges.channel[c];
      const double width = options_.strength * (double(all.maximum) - all.minimum);
      with_voxel_type(description_.format.type, [&](auto zero) {
        using Voxel = decltype(zero);
        range = {static_cast<float>(as_voxel<Voxel>(range.minimum + std::min(width * noise.low, 0.0))),
                 static_cast<float>(as_voxel<Voxel>(range.maximum + std::max(width * noise.high, 0.0)))};
      });
    }
  }
  return {};
}

Status AmplifyProducer::produce(const NodeKey& key, std::span<std::byte> voxels) const {
  GVX_TRY(check_brick(description_, voxels));
  const NodeKey above = in_volume(key);
  if (key.level <= finest_) return volume_->produce(above, voxels);
  // Not the thread's: the volume may be amplified itself.
  std::vector<std::byte> coarse(description_.brick_bytes());
  GVX_TRY(volume_->produce(above, coarse));
  const int m = static_cast<int>(description_.m), edge = m + 2 * kBrickBorder;
  constexpr double kFirst = kBrickBorder - 0.5;  // how far its centre is before the brick's first voxel
  const double parts = nodes_across(static_cast<int>(description_.n), key.level - finest_);
  const auto whole_parts = static_cast<std::uint64_t>(parts);
  const double across = nodes_across(static_cast<int>(description_.n), key.level), voxel = 1 / (across * m);
  // Where this node's first voxel, of the border, is in its ancestor's brick, in texels.
  const auto first = [&](std::uint64_t place) {
    return static_cast<double>(place % whole_parts) / parts * m + kFirst - kFirst / parts;
  };
  const Vec3d start(first(key.x), first(key.y), first(key.z));
  const Vec3d corner = gvx::corner(key) / across - Vec3d(kFirst * voxel);
  std::vector<double> noise(static_cast<std::size_t>(edge));
  with_voxel_type(description_.format.type, [&](auto zero) {
    using Voxel = decltype(zero);
    const auto* from = reinterpret_cast<const Voxel*>(coarse.data());
    auto* to = reinterpret_cast<Voxel*>(voxels.data());
    for (std::uint32_t plane = 0; plane < description_.format.planes; ++plane, from += edge * edge * edge) {
      const auto mixed = [&](Vec3d p) {
        int low[3];
        double share[3];
        for (int axis = 0; axis < 3; ++axis) {
          const double held = std::clamp(p[axis], 0.0, edge - 1.0);
          low[axis] = std::min(static_cast<int>(held), edge - 2);
          share[axis] = held - low[axis];
        }
        double sum = 0;
        for (int k = 0; k < 8; ++k) {
          const int x = k & 1, y = k >> 1 & 1, z = k >> 2;
          const double weight =
              (x ? share[0] : 1 - share[0]) * (y ? share[1] : 1 - share[1]) * (z ? share[2] : 1 - share[2]);
          sum += weight * double(from[((low[2] + z) * edge + low[1] + y) * edge + low[0] + x]);
        }
        return sum;
      };
      for (int z = 0; z < edge; ++z) {
        for (int y = 0; y < edge; ++y) {
          noise_.row(corner + voxel * Vec3d(0, y, z), voxel, static_cast<std::uint32_t>(edge), voxel,
                     noise.data(), [](const double*, double) { return false; });
          for (int x = 0; x < edge; ++x) {
            const double v = mixed(start + Vec3d(x, y, z) / parts);
            *to++ = as_voxel<Voxel>(amplified(v, description_.ranges.channel[plane],
                                              noise[static_cast<std::size_t>(x)], options_.strength));
          }
        }
      }
    }
  });
  return {};
}

}  // namespace gvx::produce
