#include "gvx/scene/even_means.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace gvx::scene {
namespace {

using Parts = std::array<double, 4>;

Parts parts_of(const Matter& m) {
  return {m.color.x, m.color.y, m.color.z, m.extinction};
}

/// From one entry to another.
struct Piece {
  std::int64_t first, last;

  std::int64_t length() const { return last - first; }
};

/// So narrow, in entries, intervals are taken to be even: their integrals' differences would be of few units.
/// The more entries there are the greater is the unit.
float narrow(std::size_t entries) {
  return TransferView::kNarrow * std::max(1.0f, float(entries) / float(TransferView::kEntries));
}

/// The widest even interval, of those whose halves were asked for: doubled as long as it is, then bisected;
/// or `narrow`. Narrower ones are taken to be even, too.
template <typename IsEven>
float widest(const IsEven& is_even, float narrow) {
  std::int64_t even = 0, uneven = 1;  // halves
  while (is_even(uneven)) even = std::exchange(uneven, 2 * uneven);
  while (uneven - even > 1) {
    const std::int64_t half = even + (uneven - even) / 2;
    (is_even(half) ? even : uneven) = half;
  }
  return even > 0 ? std::max(static_cast<float>(2 * even), narrow) : narrow;
}

/// A table's running integrals as plain numbers, also beyond its ends.
class RunningMatter {
 public:
  explicit RunningMatter(const TransferTable& table)
      : first_(parts_of(table.matter.front())), last_(parts_of(table.matter.back())) {
    Parts sum{};
    for (const TransferView::Integral& entry : table.integral) {
      sums_.push_back(sum);
      for (std::size_t i = 0; i < 4; ++i) {
        sum[i] += double(entry.density[i]);
        greatest_[i] = std::max(greatest_[i], std::min(double(entry.density[i]), kOpaque));
      }
    }
  }

  Parts mean(std::int64_t from, std::int64_t to) const {
    const Parts a = at(from), b = at(to);
    Parts mean;
    for (std::size_t i = 0; i < 4; ++i) mean[i] = (b[i] - a[i]) / double(to - from);
    return mean;
  }

  /// Is the mean of the `half` entries to either side of one that of each of the two beside it plus `bend`
  /// times the square of their number, to a small share of the greatest?
  bool is_even(std::int64_t middle, std::int64_t half, const Parts& bend) const {
    constexpr double kTolerance = 1.0 / 1024;
    const double square = double(2 * half) * double(2 * half);
    const Parts wide = mean(middle - half, middle + half);
    const Parts before = mean(middle - 1, middle), behind = mean(middle, middle + 1);
    for (std::size_t i = 0; i < 4; ++i) {
      const double like = wide[i] - bend[i] * square, most = kTolerance * greatest_[i];
      if (std::abs(like - before[i]) > most || std::abs(like - behind[i]) > most) return false;
    }
    return true;
  }

  /// The last middle whose interval in a piece is not even; or that of the first less 1.
  std::int64_t last_uneven(Piece piece, std::int64_t half, const Parts& bend) const {
    std::int64_t middle = piece.last - half;
    while (middle >= piece.first + half && is_even(middle, half, bend)) --middle;
    return middle;
  }

  bool is_even(Piece piece, std::int64_t half, const Parts& bend) const {
    return last_uneven(piece, half, bend) < piece.first + half;
  }

  /// The one that is right for a piece as a whole.
  TransferView::Parabola fitted(Piece piece) const {
    const std::int64_t middle = piece.first + piece.length() / 2, half = piece.length() / 2;
    const Parts wide = mean(middle - half, middle + half), here = mean(middle - 1, middle + 1);
    Parts bend;
    for (std::size_t i = 0; i < 4; ++i) bend[i] = (wide[i] - here[i]) / (double(2 * half) * double(2 * half));
    return parabola(piece, bend);
  }

  /// One with this bend, and the widest of a piece's intervals for which it serves.
  TransferView::Parabola parabola(Piece piece, const Parts& bend) const {
    const auto serves = [&](std::int64_t half) {
      return 2 * half <= piece.length() && is_even(piece, half, bend);
    };
    return {static_cast<float>(piece.first),
            static_cast<float>(piece.last),
            widest(serves, narrow(sums_.size())),
            {{float(bend[0]), float(bend[1]), float(bend[2])}, float(bend[3])}};
  }

  bool is_seen(Piece piece) const { return mean(piece.first, piece.last)[3] > 0; }

 private:
  // Extinction that lets next to nothing through: how much more there is says nothing of what is too far off.
  static constexpr double kOpaque = 7;

  Parts at(std::int64_t entry) const {
    const auto last = static_cast<std::int64_t>(sums_.size()) - 1;
    Parts sum = sums_[static_cast<std::size_t>(std::clamp(entry, std::int64_t(0), last))];
    for (std::size_t i = 0; i < 4; ++i) {
      if (entry < 0) sum[i] += double(entry) * first_[i];
      if (entry > last) sum[i] += double(entry - last) * last_[i];
    }
    return sum;
  }

  Parts first_, last_, greatest_{};
  std::vector<Parts> sums_;
};

/// About how many of a table's intervals a parabola serves for. Steps are seldom wider than kUsual.
float serves_for(const TransferView::Parabola& p) {
  constexpr float kUsual = 512;
  const float width = std::min(p.width, kUsual);
  return width * (p.last - p.first - 0.5f * width);
}

}  // namespace

void find_even_means(const std::vector<double>& stops, TransferTable& table) {
  const RunningMatter matter(table);
  const auto entries = static_cast<std::int64_t>(table.integral.size());
  // All intervals so wide that have something of the table.
  const auto all_of = [&](std::int64_t half) { return Piece{1 - 2 * half, entries + 2 * half}; };
  TransferView::Even& even = table.even;
  even.width =
      widest([&](std::int64_t half) { return 2 * half < entries && matter.is_even(all_of(half), half, {}); },
             narrow(table.integral.size()));
  for (std::int64_t half = 1; 2 * half < entries; half *= 2) {
    const std::int64_t middle = matter.last_uneven(all_of(half), half, {});
    if (middle > -half) even.above = std::max(even.above, static_cast<float>(middle - half + 1));
  }

  // All of the table as it is, or one of its longest pieces between stops.
  constexpr std::int64_t kShortest = 16;
  constexpr std::size_t kTried = 2;
  std::vector<Piece> pieces;
  for (std::size_t i = 0; i + 1 < stops.size(); ++i) {
    const Piece piece{static_cast<std::int64_t>(std::ceil(stops[i])),
                      static_cast<std::int64_t>(std::floor(stops[i + 1]))};
    if (piece.length() >= kShortest && matter.is_seen(piece)) pieces.push_back(piece);
  }
  std::stable_sort(pieces.begin(), pieces.end(), [](Piece a, Piece b) { return a.length() > b.length(); });
  even.piece = matter.parabola({0, entries - 1}, {});
  for (std::size_t i = 0; i < std::min(pieces.size(), kTried); ++i) {
    const TransferView::Parabola parabola = matter.fitted(pieces[i]);
    if (serves_for(parabola) > serves_for(even.piece)) even.piece = parabola;
  }
}

}  // namespace gvx::scene
