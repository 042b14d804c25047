#include "gvx/io/tiff_samples.h"

#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

namespace gvx::io {
namespace {

template <typename Word>
void copy_words(const StoredRow& row, int sample, std::int64_t count, std::byte* out,
                std::size_t pixel_bytes) {
  const std::byte* in = row.begin + static_cast<std::size_t>(sample) * sizeof(Word);
  const std::size_t step = static_cast<std::size_t>(row.samples) * sizeof(Word);
  for (std::int64_t i = 0; i < count; ++i, in += step, out += pixel_bytes) {
    std::memcpy(out, in, sizeof(Word));
  }
}

void copy_halves(const StoredRow& row, int sample, std::int64_t count, std::byte* out,
                 std::size_t pixel_bytes) {
  const std::byte* in = row.begin + static_cast<std::size_t>(sample) * 2;
  for (std::int64_t i = 0; i < count; ++i, in += 2 * row.samples, out += pixel_bytes) {
    std::uint16_t half;
    std::memcpy(&half, in, sizeof half);
    const float value = half_to_float(half);
    std::memcpy(out, &value, sizeof value);
  }
}

/// `bits` of them from the given bit on, counted from the highest bit of the first byte.
std::uint32_t bits_at(const std::byte* begin, std::uint64_t first, int bits) {
  std::uint32_t value = 0;
  for (int left = bits; left > 0;) {
    const int skipped = static_cast<int>(first % 8);
    const int taken = std::min(left, 8 - skipped);
    const auto byte = std::to_integer<std::uint32_t>(begin[first / 8]);
    value = value << taken | (byte >> (8 - skipped - taken) & ((1u << taken) - 1));
    first += static_cast<std::uint64_t>(taken);
    left -= taken;
  }
  return value;
}

void unpack_bits(const StoredRow& row, int sample, std::int64_t count, SampleType type, std::byte* out,
                 std::size_t pixel_bytes) {
  const auto bits = static_cast<std::uint64_t>(row.bits);
  const std::uint64_t step = bits * static_cast<std::uint64_t>(row.samples);
  const std::size_t bytes = sample_bytes(type);
  const bool negative_ones = type == SampleType::i8 || type == SampleType::i16 || type == SampleType::i32;
  std::uint64_t at = bits * static_cast<std::uint64_t>(sample);
  for (std::int64_t i = 0; i < count; ++i, at += step, out += pixel_bytes) {
    std::uint32_t value = 0;
    if (row.bits == 24) {
      // libtiff hands these out as three bytes in native order.
      static_assert(std::endian::native == std::endian::little);
      std::memcpy(&value, row.begin + at / 8, 3);
    } else {
      value = bits_at(row.begin, at, row.bits);
    }
    if (negative_ones && (value >> (row.bits - 1) & 1) != 0) value |= ~0u << row.bits;
    std::memcpy(out, &value, bytes);
  }
}

}  // namespace

float half_to_float(std::uint16_t half) {
  const int exponent = half >> 10 & 31, fraction = half & 1023;
  float value = 0;
  if (exponent == 31) {
    value = fraction == 0 ? std::numeric_limits<float>::infinity() : std::numeric_limits<float>::quiet_NaN();
  } else {
    value = exponent == 0 ? std::ldexp(static_cast<float>(fraction), -24)
                          : std::ldexp(static_cast<float>(1024 + fraction), exponent - 25);
  }
  return (half & 0x8000) != 0 ? -value : value;
}

bool stored_as_handed_out(const TiffPage& page) {
  return static_cast<std::size_t>(page.bits) == 8 * sample_bytes(page.type);
}

void unpack_samples(const StoredRow& row, int sample, std::int64_t count, SampleType type, std::byte* out,
                    std::size_t pixel_bytes) {
  if (row.floating && row.bits == 16) return copy_halves(row, sample, count, out, pixel_bytes);
  switch (row.bits) {
    case 8:
      return copy_words<std::uint8_t>(row, sample, count, out, pixel_bytes);
    case 16:
      return copy_words<std::uint16_t>(row, sample, count, out, pixel_bytes);
    case 32:
      return copy_words<std::uint32_t>(row, sample, count, out, pixel_bytes);
    case 64:
      return copy_words<std::uint64_t>(row, sample, count, out, pixel_bytes);
    default:
      return unpack_bits(row, sample, count, type, out, pixel_bytes);
  }
}

}  // namespace gvx::io
