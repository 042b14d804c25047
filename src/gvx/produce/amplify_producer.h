/// \file
/// AmplifyProducer: a volume with detail that it does not have: below its finest level noise goes on where
/// its values change (amplification, section 6.3 of the 2008 report).
#pragma once

#include <memory>

#include "gvx/core/added_noise.h"
#include "gvx/produce/producer.h"

namespace gvx::produce {

struct AmplifyOptions {
  std::uint32_t levels = 3;  ///< how many finer ones there are
  double strength = 0.35;    ///< of the first octave, in ranges of the volume's values
  double wavelength = 6;     ///< of the first octave, in voxels of the volume
  double gain = 0.6;         ///< how strong an octave is, beside the one before
  std::uint32_t seed = 1;
};

/// The noise that amplifies a volume.
AddedNoise amplification(const TreeDescription& volume, const AmplifyOptions& options);

/// Values are mixed between the volume's voxels, and noise is added, most of it in the middle of the values'
/// range and none at its ends: what is empty or full stays so. No two nodes are the same, not even those that
/// the volume shares, as the noise of each is another.
class AmplifyProducer final : public Producer {
 public:
  /// An error where the voxels are no scalars or there would be more nodes than a key can name.
  static Result<std::shared_ptr<const AmplifyProducer>> create(std::shared_ptr<const Producer> volume,
                                                               const AmplifyOptions& options);

  const TreeDescription& description() const override { return description_; }
  Status describe(std::span<const NodeKey> keys, std::span<tree::NodeInfo> infos) const override;
  Status produce(const NodeKey& key, std::span<std::byte> voxels) const override;
  std::uint64_t wanted_memory() const override { return volume_->wanted_memory(); }
  void keep_at_most(std::uint64_t bytes) const override { volume_->keep_at_most(bytes); }
  std::uint64_t bytes_read() const override { return volume_->bytes_read(); }
  ProductionTimes times() const override { return volume_->times(); }

 private:
  AmplifyProducer(std::shared_ptr<const Producer> volume, const AmplifyOptions& options);
  /// The node of the volume that holds this one.
  NodeKey in_volume(const NodeKey& key) const;

  std::shared_ptr<const Producer> volume_;
  std::uint32_t finest_;  // level of the volume
  AmplifyOptions options_;
  FractalNoise noise_;
  TreeDescription description_;
};

}  // namespace gvx::produce
