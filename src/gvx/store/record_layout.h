/// \file
/// RecordLayout: which bytes of a node's record mean what. The store says so itself, field by field and each
/// with a name, so that a store may hold more of a node than a reader knows: the reader takes the fields that
/// it knows, and skips the others.
///
///     voxels   16 bytes: where the node's compressed brick is
///     ranges   8 bytes a channel: least and greatest value
///     ...      fields of stores to come
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "gvx/core/result.h"
#include "gvx/core/voxel.h"
#include "gvx/store/format.h"
#include "gvx/store/sections.h"

namespace gvx::store {

/// The numbers are those of the file.
enum class FieldKind : std::uint32_t {
  payload = 1,  ///< a BlockRef: bytes elsewhere in the file, none where it has 0
  values = 2    ///< what it says stands in the record itself
};

/// A field as the section "records" lists it.
struct RecordField {
  StoredName name;
  std::uint32_t kind;    ///< FieldKind; fields of other kinds are skipped
  std::uint32_t offset;  ///< in the record
  std::uint32_t bytes;
  std::uint32_t flags;  ///< bit 0: a reader must know the field
};
static_assert(sizeof(RecordField) == 40);

/// Where the known fields are in a record, and which others there are.
class RecordLayout {
 public:
  /// A field beyond those that every store has.
  struct Extra {
    std::string name;
    FieldKind kind = FieldKind::payload;
    std::uint32_t bytes = sizeof(BlockRef);
    bool required = false;
  };

  /// Of the records that this program writes. `extras` stand behind the others.
  explicit RecordLayout(const VoxelFormat& format, std::span<const Extra> extras = {});
  /// Of version 2: always four ranges.
  static RecordLayout version2();
  /// What a store's section says; an error where fields overlap, are not within the record, or lack what this
  /// program needs.
  static Result<RecordLayout> parse(const StoreFile& file, std::span<const RecordField> fields,
                                    std::uint32_t record_bytes, const VoxelFormat& format);

  std::uint32_t bytes() const { return bytes_; }
  const std::vector<RecordField>& fields() const { return fields_; }

  /// The known fields of a record.
  NodeRecord decode(const std::byte* record) const;
  /// Writes the known fields; leaves the bytes of others as they are.
  void encode(const NodeRecord& node, std::byte* record) const;

  /// Payloads that this program does not know.
  struct Payload {
    std::string name;
    std::uint32_t offset;  ///< in the record
  };
  const std::vector<Payload>& other_payloads() const { return others_; }

 private:
  RecordLayout() = default;

  std::uint32_t bytes_ = 0, voxels_ = 0, ranges_ = 0;
  std::uint32_t channels_ = 0;  ///< ranges that a record holds
  std::vector<RecordField> fields_;
  std::vector<Payload> others_;
};

/// The most bytes that a record may have.
inline constexpr std::uint32_t kMostRecordBytes = 4096;
/// The most fields that a record may have.
inline constexpr std::uint32_t kMostFields = 64;

}  // namespace gvx::store
