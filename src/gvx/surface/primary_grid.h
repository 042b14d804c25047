/// \file
/// PrimaryGridView: the cells of a surface brick as a grid of columns along one axis, its primary one, with
/// the rank of each cell among the brick's samples. Its bytes are of one of two forms, whichever takes fewer:
///
///     heights:
///     1024 bytes   of each column kEmpty, kMany, or the depth of its only sample
///     32 rows      masks of columns with one sample and with many, 4 bytes each;
///                  how many of the one and of the other come before, 2 bytes each
///     columns      of each with many: its first span, and the samples before;
///                  2 bytes each, and so once more behind the last
///     spans        where one starts, and its length less one: 1 byte each
///
///     masks:
///     1024 words   of each column, a bit for each cell
///     32 numbers   samples in the rows before, 2 bytes each
///
/// In heights, ranks are those of single samples, row by row, and then of the others. Numbers are
/// little-endian, as processors that gvx runs on have them.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "gvx/core/macros.h"
#include "gvx/core/result.h"
#include "gvx/surface/cell_set.h"

namespace gvx::surface {

enum class GridForm : std::uint8_t { heights, masks };

/// The numbers of bits of a word, on any device.
GVX_HD inline int bits_in(std::uint32_t word) {
#if defined(__CUDA_ARCH__)
  return __popc(word);
#else
  return std::popcount(word);
#endif
}
GVX_HD inline int lowest_bit(std::uint32_t word) {
#if defined(__CUDA_ARCH__)
  return __ffs(static_cast<int>(word)) - 1;
#else
  return std::countr_zero(word);
#endif
}
GVX_HD inline int highest_bit(std::uint32_t word) {
#if defined(__CUDA_ARCH__)
  return 31 - __clz(static_cast<int>(word));
#else
  return 31 - std::countl_zero(word);
#endif
}
/// Bits `first` to `last` of a word, both from 0 to 31.
GVX_HD inline std::uint32_t bits_between(int first, int last) {
  return (~std::uint32_t{0} << first) & (~std::uint32_t{0} >> (31 - last));
}

struct PrimaryGridView {
  const std::byte* bytes = nullptr;
  GridForm form = GridForm::heights;

  static constexpr std::uint8_t kEmpty = 255, kMany = 254;
  static constexpr int kColumns = kCells * kCells;
  static constexpr int kRowBytes = 12, kManyBytes = 4, kSpanBytes = 2;
  static constexpr int kRows = kColumns, kManies = kRows + kCells * kRowBytes;

  /// The cells of a column, a bit each.
  GVX_HD std::uint32_t column(int u, int v) const {
    if (form == GridForm::masks) return word(4 * column_at(u, v));
    const auto depth = static_cast<std::uint8_t>(bytes[column_at(u, v)]);
    if (depth == kEmpty) return 0;
    if (depth != kMany) return std::uint32_t{1} << depth;
    const int many = many_before(u, v);
    const int first = half(kManies + many * kManyBytes), end = half(kManies + (many + 1) * kManyBytes);
    std::uint32_t cells = 0;
    for (int span = first; span < end; ++span) {
      const int at = spans() + span * kSpanBytes;
      const int start = static_cast<int>(bytes[at]), more = static_cast<int>(bytes[at + 1]);
      cells |= bits_between(start, start + more);
    }
    return cells;
  }

  /// The rank of a cell that is there.
  GVX_HD std::uint32_t rank(int u, int v, int w) const {
    if (form == GridForm::masks) {
      int before = half(4 * kColumns + 2 * v);
      for (int i = 0; i < u; ++i) before += bits_in(word(4 * column_at(i, v)));
      return static_cast<std::uint32_t>(before + bits_in(column(u, v) & below(w)));
    }
    const int row = kRows + v * kRowBytes;
    if (static_cast<std::uint8_t>(bytes[column_at(u, v)]) != kMany)
      return static_cast<std::uint32_t>(half(row + 8) + bits_in(word(row) & below(u)));
    const int many = many_before(u, v), before = half(kManies + many * kManyBytes + 2);
    return static_cast<std::uint32_t>(singles() + before + bits_in(column(u, v) & below(w)));
  }

 private:
  GVX_HD static std::uint32_t below(int bit) { return (std::uint32_t{1} << bit) - 1; }
  GVX_HD std::uint32_t word(int at) const {
    std::uint32_t value;
    std::memcpy(&value, bytes + at, sizeof(value));
    return value;
  }
  GVX_HD int half(int at) const {
    std::uint16_t value;
    std::memcpy(&value, bytes + at, sizeof(value));
    return value;
  }
  /// Columns with many samples before this one.
  GVX_HD int many_before(int u, int v) const {
    const int row = kRows + v * kRowBytes;
    return half(row + 10) + bits_in(word(row + 4) & below(u));
  }
  /// All columns with one sample, and all with many.
  GVX_HD int singles() const {
    const int last = kRows + (kCells - 1) * kRowBytes;
    return half(last + 8) + bits_in(word(last));
  }
  GVX_HD int spans() const {
    const int last = kRows + (kCells - 1) * kRowBytes;
    return kManies + (half(last + 10) + bits_in(word(last + 4)) + 1) * kManyBytes;
  }
};

/// The bytes of a grid.
struct PrimaryGrid {
  GridForm form = GridForm::heights;
  std::vector<std::byte> bytes;

  PrimaryGridView view() const { return {bytes.data(), form}; }
};

/// Of columns along the primary axis.
PrimaryGrid make_grid(const std::array<std::uint32_t, kCells * kCells>& columns, GridForm form);
/// In the form that takes fewer bytes.
PrimaryGrid make_grid(const std::array<std::uint32_t, kCells * kCells>& columns);

/// An error where bytes, which may be of a damaged file, are no grid of this form: then a view of them would
/// read beyond them. Else how many samples it has.
Result<std::uint32_t> check_grid(GridForm form, std::span<const std::byte> bytes);

}  // namespace gvx::surface
