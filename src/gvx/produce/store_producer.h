/// \file
/// StoreProducer: the bricks of a .gvx store.
#pragma once

#include <memory>

#include "gvx/produce/producer.h"
#include "gvx/store/store_reader.h"

namespace gvx::produce {

class StoreProducer final : public Producer {
 public:
  /// Without a reader, describe() and produce(), and so Engine::create(), return an error.
  explicit StoreProducer(std::unique_ptr<store::StoreReader> reader);

  const TreeDescription& description() const override { return description_; }
  Status describe(std::span<const NodeKey> keys, std::span<tree::NodeInfo> infos) const override;
  Status produce(const NodeKey& key, std::span<std::byte> voxels) const override;
  std::uint64_t wanted_memory() const override { return reader_ ? reader_->index().wanted_bytes() : 0; }
  void keep_at_most(std::uint64_t bytes) const override {
    if (reader_ != nullptr) reader_->index().keep_at_most(bytes);
  }
  std::uint64_t bytes_read() const override { return reader_ ? reader_->bytes_read() : 0; }
  ProductionTimes times() const override {
    if (reader_ == nullptr) return {};
    return {reader_->reading_milliseconds(), reader_->decoding_milliseconds()};
  }

 private:
  std::unique_ptr<store::StoreReader> reader_;
  TreeDescription description_;
};

}  // namespace gvx::produce
