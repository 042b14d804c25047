/// \file
/// ValueHistogram counts voxels whose range is not known until all have come. Floats that are NaN are no
/// data.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <vector>

#include "gvx/core/voxel.h"

namespace gvx::store {

template <typename Voxel>
class ValueHistogram {
 public:
  void add(const Voxel* voxels, std::int64_t count) {
    // Tables in turn: equal neighbours would otherwise wait for each other's increment.
    std::uint32_t* tables[kTables];
    for (std::size_t k = 0; k < kTables; ++k) {
      std::fill(tables_[k].begin(), tables_[k].end(), 0u);
      tables[k] = tables_[k].data();
    }
    std::int64_t i = 0;
    if constexpr (sizeof(Voxel) == 1) {
      for (; i + 8 <= count; i += 8) {
        std::uint64_t eight;
        std::memcpy(&eight, voxels + i, sizeof(eight));
        for (std::size_t k = 0; k < 8; ++k) ++tables[k][eight >> (8 * k) & 255];
      }
    }
    for (; i + 1 < count; i += 2) {
      ++tables[0][fine_bin(voxels[i])];
      ++tables[1][fine_bin(voxels[i + 1])];
    }
    if (i < count) ++tables[0][fine_bin(voxels[i])];
    for (const auto& table : tables_) {
      for (std::size_t bin = 0; bin < fine_.size(); ++bin) fine_[bin] += table[bin];
    }
  }

  void add(const ValueHistogram& other) {
    for (std::size_t i = 0; i < fine_.size(); ++i) fine_[i] += other.fine_[i];
  }

  /// The counts in equal bins over the range. Floats are counted by their first 16 bits: where those tell
  /// fewer values apart than there are bins, they are taken to lie evenly between.
  std::vector<std::uint64_t> bins(ValueRange range, std::size_t count) const {
    std::vector<std::uint64_t> bins(count);
    const double least = range.minimum, width = range.maximum - least;
    for (std::size_t i = 0; i < fine_.size(); ++i) {
      if (fine_[i] == 0 || !std::isfinite(fine_bin_value(i))) continue;
      const auto bin_of = [&](double value) {
        const double where = width > 0 ? (value - least) / width : 0;
        return std::clamp(where * static_cast<double>(count), 0.0, static_cast<double>(count));
      };
      const double first = bin_of(fine_bin_value(i));
      double last = first;
      if (std::is_same_v<Voxel, float> && i + 1 < fine_.size()) last = bin_of(fine_bin_value(i + 1));
      if (!(last - first > 1)) last = first;
      std::uint64_t put = 0;
      for (auto bin = static_cast<std::size_t>(std::min(first, static_cast<double>(count - 1)));
           put < fine_[i]; ++bin) {
        const double share = last > first ? (static_cast<double>(bin + 1) - first) / (last - first) : 1;
        const auto up_to = share < 1 && bin + 1 < count
                               ? static_cast<std::uint64_t>(share * static_cast<double>(fine_[i]))
                               : fine_[i];
        bins[bin] += up_to - put;
        put = up_to;
      }
    }
    return bins;
  }

  /// Were any of the voxels no data?
  bool any_no_data() const {
    for (std::size_t i = 0; i < fine_.size(); ++i) {
      if (fine_[i] != 0 && !std::isfinite(fine_bin_value(i))) return true;
    }
    return false;
  }

 private:
  static constexpr std::size_t kFineBins = sizeof(Voxel) == 1 ? 256 : 65536;
  static constexpr std::size_t kTables = sizeof(Voxel) == 1 ? 8 : 2;

  static auto made_tables() {
    std::array<std::vector<std::uint32_t>, kTables> tables;
    for (auto& table : tables) table.resize(kFineBins);
    return tables;
  }

  /// The value itself, or the 16 high bits of a float's order-preserving image.
  static std::size_t fine_bin(Voxel v) {
    if constexpr (std::is_same_v<Voxel, float>) {
      const auto bits = std::bit_cast<std::uint32_t>(v);
      return ((bits & 0x80000000u) != 0 ? ~bits : bits | 0x80000000u) >> 16;
    } else {
      return v;
    }
  }

  /// The least value of a fine bin.
  static double fine_bin_value(std::size_t bin) {
    if constexpr (std::is_same_v<Voxel, float>) {
      const auto high = static_cast<std::uint32_t>(bin) << 16;
      return std::bit_cast<float>((high & 0x80000000u) != 0 ? high & 0x7fffffffu : ~high);
    } else {
      return static_cast<double>(bin);
    }
  }

  std::vector<std::uint64_t> fine_ = std::vector<std::uint64_t>(kFineBins);
  std::array<std::vector<std::uint32_t>, kTables> tables_ = made_tables();
};

}  // namespace gvx::store
