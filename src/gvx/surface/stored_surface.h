/// \file
/// StoredSurface: the producer of a surface store: it reads pages of nodes and pieces of bricks.
#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "gvx/produce/producer.h"
#include "gvx/surface/surface_reader.h"

namespace gvx::surface {

/// How production calls a piece, and a page.
inline produce::ElementKind kind_of(Piece piece) {
  return static_cast<produce::ElementKind>(
      static_cast<std::uint32_t>(produce::ElementKind::surface_geometry) + static_cast<std::uint32_t>(piece));
}

class StoredSurface final : public produce::Producer {
 public:
  /// Reads a few pages of nodes, too; an error if the file is no sound surface store.
  static Result<std::shared_ptr<const StoredSurface>> open(const std::string& path);
  static Result<std::shared_ptr<const StoredSurface>> of(std::unique_ptr<SurfaceReader> reader);

  const SurfaceInfo& info() const { return reader_->info(); }
  const produce::TreeDescription& description() const override { return description_; }
  void start(const produce::ElementBatch& batch, std::shared_ptr<produce::ElementSink> sink) const override;
  produce::Batching batching() const override { return {.most = 16}; }
  std::uint64_t bytes_read() const override { return reader_->bytes_read(); }
  produce::ProductionTimes times() const override {
    return {reader_->file().reading_milliseconds(), reader_->file().decoding().milliseconds()};
  }

  /// A surface has no voxels.
  Status describe(std::span<const NodeKey> keys, std::span<tree::NodeInfo> infos) const override;
  Status produce(const NodeKey& key, std::span<std::byte> voxels) const override;

 private:
  explicit StoredSurface(std::unique_ptr<SurfaceReader> reader);

  using Page = std::shared_ptr<const std::vector<SurfaceNode>>;
  /// Pages in which pieces were looked up last are kept.
  struct KeptPage {
    std::uint32_t level = 0;
    std::uint64_t number = 0;
    Page page;
  };

  Result<Page> page_of(std::uint32_t level, std::uint64_t place) const;
  Result<produce::Element> make(produce::ElementKind kind, const NodeKey& key) const;

  std::unique_ptr<SurfaceReader> reader_;
  produce::TreeDescription description_;
  mutable std::mutex mutex_;
  mutable std::list<KeptPage> pages_;  // the last used is first
};

/// The tree of a surface, as cameras and scenes take it.
produce::TreeDescription describe_surface(const SurfaceInfo& info);

}  // namespace gvx::surface
