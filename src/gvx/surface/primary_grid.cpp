#include "gvx/surface/primary_grid.h"

#include <algorithm>
#include <string>
#include <utility>

namespace gvx::surface {
namespace {

using View = PrimaryGridView;
using Columns = std::array<std::uint32_t, kCells * kCells>;

std::uint32_t column_of(const Columns& columns, int u, int v) {
  return columns[static_cast<std::size_t>(column_at(u, v))];
}

/// Little-endian numbers, one after the other.
class Numbers {
 public:
  explicit Numbers(std::vector<std::byte>& bytes) : bytes_(bytes) {}
  void add(std::size_t value, int count) {
    for (int i = 0; i < count; ++i) bytes_.push_back(static_cast<std::byte>(value >> 8 * i));
  }

 private:
  std::vector<std::byte>& bytes_;
};

/// The runs of ones of a word, from below: calls function(start, length).
template <typename Function>
void for_spans(std::uint32_t word, Function function) {
  while (word != 0) {
    const int start = std::countr_zero(word), length = std::countr_one(word >> start);
    function(start, length);
    word &= ~bits_between(start, start + length - 1);
  }
}

std::vector<std::byte> masks_of(const Columns& columns) {
  std::vector<std::byte> bytes;
  Numbers numbers(bytes);
  for (const std::uint32_t column : columns) numbers.add(column, 4);
  std::size_t before = 0;
  for (int v = 0; v < kCells; ++v) {
    numbers.add(before, 2);
    for (int u = 0; u < kCells; ++u) before += static_cast<std::size_t>(bits_in(column_of(columns, u, v)));
  }
  return bytes;
}

std::vector<std::byte> heights_of(const Columns& columns) {
  std::vector<std::byte> bytes, rows, manies, spans;
  Numbers depths(bytes), row(rows), many(manies), span(spans);
  std::size_t singles_before = 0, manies_before = 0, spans_before = 0, samples_before = 0;
  for (int v = 0; v < kCells; ++v) {
    std::uint32_t single_mask = 0, many_mask = 0;
    for (int u = 0; u < kCells; ++u) {
      const std::uint32_t column = column_of(columns, u, v);
      const int count = bits_in(column);
      const std::uint8_t single = count == 0 ? View::kEmpty : static_cast<std::uint8_t>(lowest_bit(column));
      depths.add(count > 1 ? View::kMany : single, 1);
      if (count == 1) single_mask |= 1u << u;
      if (count <= 1) continue;
      many_mask |= 1u << u;
      many.add(spans_before, 2);
      many.add(samples_before, 2);
      for_spans(column, [&](int start, int length) {
        span.add(static_cast<std::size_t>(start), 1);
        span.add(static_cast<std::size_t>(length) - 1, 1);
        ++spans_before;
      });
      samples_before += static_cast<std::size_t>(count);
    }
    row.add(single_mask, 4);
    row.add(many_mask, 4);
    row.add(singles_before, 2);
    row.add(manies_before, 2);
    singles_before += static_cast<std::size_t>(bits_in(single_mask));
    manies_before += static_cast<std::size_t>(bits_in(many_mask));
  }
  many.add(spans_before, 2);
  many.add(samples_before, 2);
  for (const auto* part : {&rows, &manies, &spans}) bytes.insert(bytes.end(), part->begin(), part->end());
  return bytes;
}

Error damaged(const std::string& what) {
  return Error{"surface brick: " + what};
}

}  // namespace

PrimaryGrid make_grid(const Columns& columns, GridForm form) {
  return {form, form == GridForm::masks ? masks_of(columns) : heights_of(columns)};
}

PrimaryGrid make_grid(const Columns& columns) {
  PrimaryGrid heights = make_grid(columns, GridForm::heights);
  constexpr std::size_t kMaskBytes = 4 * View::kColumns + 2 * kCells;
  return heights.bytes.size() <= kMaskBytes ? std::move(heights) : make_grid(columns, GridForm::masks);
}

// What is right is what make_grid() makes of the same columns; to read these, offsets are checked first.
Result<std::uint32_t> check_grid(GridForm form, std::span<const std::byte> bytes) {
  Columns columns{};
  const PrimaryGridView view{bytes.data(), form};
  if (form == GridForm::masks) {
    if (bytes.size() != 4 * View::kColumns + 2 * kCells) return damaged("its masks have another size");
  } else {
    if (bytes.size() < View::kManies + View::kManyBytes) return damaged("its heights are cut short");
    const auto half = [&](std::size_t at) {
      return static_cast<std::size_t>(bytes[at]) | static_cast<std::size_t>(bytes[at + 1]) << 8;
    };
    std::size_t manies = 0;
    for (std::size_t i = 0; i < View::kColumns; ++i) manies += bytes[i] == std::byte{View::kMany} ? 1 : 0;
    const std::size_t spans = View::kManies + (manies + 1) * View::kManyBytes;
    if (bytes.size() < spans) return damaged("its columns are cut short");
    const std::size_t count = (bytes.size() - spans) / View::kSpanBytes;
    for (std::size_t i = 0; i <= manies; ++i) {
      if (half(View::kManies + i * View::kManyBytes) > count) return damaged("spans lie beyond its end");
    }
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t at = spans + i * View::kSpanBytes;
      if (static_cast<int>(bytes[at]) + static_cast<int>(bytes[at + 1]) >= kCells)
        return damaged("a span is too long");
    }
    std::size_t before = 0;
    for (std::size_t v = 0; v < kCells; ++v) {
      const std::size_t row = View::kRows + v * View::kRowBytes;
      std::uint32_t mask = 0;
      for (std::size_t u = 0; u < kCells; ++u) {
        const auto depth = static_cast<std::uint8_t>(bytes[v * kCells + u]);
        if (depth == View::kMany) mask |= 1u << u;
        if (depth < View::kMany && depth >= kCells) return damaged("a depth is beyond its cells");
      }
      const std::uint32_t stored = static_cast<std::uint32_t>(half(row + 4) | half(row + 6) << 16);
      if (stored != mask || half(row + 10) != before) return damaged("its rows do not agree with its depths");
      before += static_cast<std::size_t>(bits_in(mask));
    }
  }
  std::uint32_t samples = 0;
  for (int v = 0; v < kCells; ++v) {
    for (int u = 0; u < kCells; ++u) {
      std::uint32_t& column = columns[static_cast<std::size_t>(column_at(u, v))];
      column = view.column(u, v);
      samples += static_cast<std::uint32_t>(bits_in(column));
    }
  }
  const PrimaryGrid right = make_grid(columns, form);
  if (!std::equal(bytes.begin(), bytes.end(), right.bytes.begin(), right.bytes.end())) {
    return damaged("its ranks do not agree with its cells");
  }
  return samples;
}

}  // namespace gvx::surface
