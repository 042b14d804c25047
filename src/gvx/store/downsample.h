/// \file
/// One voxel of a level out of the n^3 below it: means and variances of scalars and their codes, the most
/// frequent label, and colours that stay as opaque as what they stand for. A float that is NaN is no data: it
/// takes no part, and what has nothing else below it is NaN too, its variance with it.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <type_traits>

namespace gvx::store {

/// The mean of scalars and the variance of the finest voxels that it stands for.
struct Moments {
  double mean = 0, variance = 0;
};

/// Is it a float that is NaN?
template <typename Voxel>
bool is_no_data(Voxel value) {
  if constexpr (std::is_same_v<Voxel, float>) return std::isnan(value);
  return false;
}

/// Sums up voxels that each stand for equally many of the finest ones.
template <typename Voxel>
class MomentSum {
 public:
  void add(Voxel value, float variance) {
    if (is_no_data(value)) return;
    sum_ += value;
    squares_ += static_cast<Square>(value) * value;
    variance_ += variance;
    ++count_;
  }
  Moments moments() const {
    if (count_ == 0) return {NAN, NAN};
    const auto n = static_cast<double>(count_);
    const double mean = static_cast<double>(sum_) / n;
    return {mean, std::max(0.0, static_cast<double>(squares_) / n - mean * mean) + variance_ / n};
  }

 private:
  using Sum = std::conditional_t<std::is_same_v<Voxel, float>, double, std::uint32_t>;
  using Square = std::conditional_t<std::is_same_v<Voxel, float>, double,
                                    std::conditional_t<sizeof(Voxel) == 1, std::uint32_t, std::uint64_t>>;
  Sum sum_ = 0;
  Square squares_ = 0;
  double variance_ = 0;
  std::uint32_t count_ = 0;
};

/// The mean as a voxel.
template <typename Voxel>
Voxel rounded(double mean) {
  if constexpr (std::is_same_v<Voxel, float>) {
    return static_cast<float>(mean);
  } else {
    return static_cast<Voxel>(std::floor(mean + 0.5));
  }
}

inline constexpr std::int64_t kEights = 128;  ///< voxels of a coarser level that are made side by side

/// Up to kEights voxels, each of 2 x 2 x 2 that stand in four rows: what MomentSum says. `below`: the
/// variances of those; none for the finest level.
template <typename Voxel>
void average_eights(const Voxel* const (&row)[4], const float* const (*below)[4], std::int64_t count,
                    Voxel* means, float* variances) {
  using Number = std::conditional_t<sizeof(Voxel) == 1, std::int32_t, double>;
  Number sum[kEights], squares[kEights];
  double variance[kEights];
  for (std::int64_t x = 0; x < count; ++x) {
    Number s = 0, q = 0;
    for (const Voxel* const voxels : row) {
      const auto a = static_cast<Number>(voxels[2 * x]), b = static_cast<Number>(voxels[2 * x + 1]);
      s = s + a + b;
      q = q + a * a + b * b;
    }
    sum[x] = s;
    squares[x] = q;
  }
  for (std::int64_t x = 0; x < count; ++x) {
    if constexpr (sizeof(Voxel) == 1) {
      means[x] = static_cast<Voxel>((sum[x] + 4) / 8);
      variance[x] = static_cast<double>(8 * squares[x] - sum[x] * sum[x]) / 64;
    } else {
      const double mean = sum[x] / 8;
      means[x] = rounded<Voxel>(mean);
      variance[x] = std::max(0.0, squares[x] / 8 - mean * mean);
    }
  }
  if (below != nullptr) {
    for (std::int64_t x = 0; x < count; ++x) {
      double more = 0;
      for (const float* const of_row : *below) {
        more = more + static_cast<double>(of_row[2 * x]) + static_cast<double>(of_row[2 * x + 1]);
      }
      variance[x] += more / 8;
    }
  }
  for (std::int64_t x = 0; x < count; ++x) variances[x] = static_cast<float>(variance[x]);
  if constexpr (std::is_same_v<Voxel, float>) {
    for (std::int64_t x = 0; x < count; ++x) {
      if (!std::isnan(sum[x])) continue;
      MomentSum<Voxel> existing;
      for (int r = 0; r < 4; ++r) {
        for (std::int64_t i = 2 * x; i < 2 * x + 2; ++i)
          existing.add(row[r][i], below != nullptr ? (*below)[r][i] : 0.0f);
      }
      means[x] = rounded<Voxel>(existing.moments().mean);
      variances[x] = static_cast<float>(existing.moments().variance);
    }
  }
}

/// The unit for deviations up to `greatest`: it has the code's last exponent but one, so that rounding up
/// fits.
inline float deviation_unit(float greatest) {
  if (!(greatest > 0)) return 0;
  int exponent = 0;
  std::frexp(greatest, &exponent);
  return std::ldexp(1.0f, exponent - 15);
}

/// The code (core/voxel.h) nearest to a deviation of up to 2^15 units.
inline std::uint8_t deviation_code(float deviation, float unit) {
  if (!(unit > 0) || !(deviation >= 0.5f * unit)) return 0;
  // A code is the exponent and the first bits of the mantissa of a float, rounded.
  constexpr std::uint32_t kDropped = 19, kOne = 127u << 4;
  const auto bits = std::bit_cast<std::uint32_t>(deviation / unit);
  const std::uint32_t rounded_bits = (bits + (1u << (kDropped - 1))) >> kDropped;
  return static_cast<std::uint8_t>(std::clamp(rounded_bits, kOne + 1, kOne + 255) - kOne);
}

/// Up to kEights sums, each of 2 x 2 x 2 numbers that stand in four rows.
inline void sum_eights(const float* const (&row)[4], std::int64_t count, float* sums) {
  float sum[kEights];  // nobody else's: the compiler makes vectors of it
  for (std::int64_t x = 0; x < count; ++x) {
    float s = 0;
    for (const float* const numbers : row) s += numbers[2 * x] + numbers[2 * x + 1];
    sum[x] = s;
  }
  std::copy_n(sum, count, sums);
}

/// The root of the mean of those of 2 x 2 x 2 variances that are not NaN, in columns a and b of four rows; 0
/// where all are.
inline float deviation_of_existing(const float* const (&row)[4], std::int64_t a, std::int64_t b) {
  float sum = 0;
  int count = 0;
  for (const float* const numbers : row) {
    for (const float number : {numbers[a], numbers[b]}) {
      if (std::isnan(number)) continue;
      sum += number;
      ++count;
    }
  }
  return count > 0 ? std::sqrt(sum / static_cast<float>(count)) : 0;
}

/// The least and the greatest of many rows of voxels, and whether any of them is no data. Where all are, the
/// least is above the greatest.
template <typename Voxel>
class Extremes {
 public:
  void add(const Voxel* row, std::int64_t count) {
    if (count < kSide) {
      for (std::int64_t i = 0; i < count; ++i) {
        least_[0] = std::min<Voxel>(least_[0], row[i]);
        greatest_[0] = std::max<Voxel>(greatest_[0], row[i]);
        any_no_data_ = any_no_data_ || is_no_data(row[i]);
      }
      return;
    }
    for (std::int64_t i = 0; i + kSide < count; i += kSide) add_side(row + i);
    add_side(row + count - kSide);
  }
  Voxel least() const {
    Voxel least = least_[0];
    for (int i = 1; i < kSide; ++i) least = std::min<Voxel>(least, least_[i]);
    return least;
  }
  Voxel greatest() const {
    Voxel greatest = greatest_[0];
    for (int i = 1; i < kSide; ++i) greatest = std::max<Voxel>(greatest, greatest_[i]);
    return greatest;
  }

  bool any_no_data() const {
    bool any = any_no_data_;
    if constexpr (std::is_same_v<Voxel, float>) {
      for (int i = 0; i < kSide; ++i) any = any || unlike_itself_[i] != 0;
    }
    return any;
  }

 private:
  // g++ and clang know vectors; of loops over bytes, which might be anything's, they make none.
  typedef Voxel Side __attribute__((vector_size(16)));
  static constexpr std::int64_t kSide = sizeof(Side) / sizeof(Voxel);

  void add_side(const Voxel* row) {
    Side voxels;
    std::memcpy(&voxels, row, sizeof(voxels));
    least_ = voxels < least_ ? voxels : least_;
    greatest_ = voxels > greatest_ ? voxels : greatest_;
    if constexpr (std::is_same_v<Voxel, float>) unlike_itself_ |= voxels != voxels;
  }

  Side least_ = std::numeric_limits<Voxel>::max() - Side{};
  Side greatest_ = std::numeric_limits<Voxel>::lowest() + Side{};
  decltype(Side{} != Side{}) unlike_itself_{};
  bool any_no_data_ = false;
};

/// The label that most of the first `count` have; of equally many the greatest, so that thin things outlive
/// the background 0.
template <typename Voxel>
Voxel most_frequent(std::array<Voxel, 27> labels, std::size_t count) {
  std::sort(labels.begin(), labels.begin() + static_cast<std::ptrdiff_t>(count));
  Voxel best = labels[0];
  std::size_t most = 0, run = 0;
  for (std::size_t i = 0; i < count; ++i) {
    run = i > 0 && labels[i] == labels[i - 1] ? run + 1 : 1;
    if (run >= most) {
      most = run;
      best = labels[i];
    }
  }
  return best;
}

/// Premultiplied colour and opacity, 0 to 1.
using Rgba = std::array<float, 4>;

inline Rgba over(const Rgba& front, const Rgba& back) {
  Rgba out;
  for (std::size_t c = 0; c < 4; ++c) out[c] = front[c] + (1 - front[3]) * back[c];
  return out;
}

/// What a block of nx x ny x nz voxels looks like as one voxel: each column seen along each axis, from both
/// ends, and the mean of all (compare the GigaVoxels thesis, section 3.1: opacity is pre-integrated, not
/// averaged).
inline Rgba seen_from_all_sides(const std::array<Rgba, 27>& block, int nx, int ny, int nz) {
  const int size[3] = {nx, ny, nz}, step[3] = {1, nx, nx * ny};
  Rgba sum{};
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    const float weight = 1.0f / static_cast<float>(6 * size[u] * size[v]);
    for (int j = 0; j < size[v]; ++j) {
      for (int i = 0; i < size[u]; ++i) {
        Rgba forth{}, back{};
        for (int k = 0; k < size[axis]; ++k) {
          const Rgba& here =
              block[std::size_t(i) * std::size_t(step[u]) + std::size_t(j) * std::size_t(step[v]) +
                    std::size_t(k) * std::size_t(step[axis])];
          forth = over(forth, here);
          back = over(here, back);
        }
        for (std::size_t c = 0; c < 4; ++c) sum[c] += weight * (forth[c] + back[c]);
      }
    }
  }
  return sum;
}

}  // namespace gvx::store
