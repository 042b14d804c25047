#include "gvx/store/codec.h"

#include <cstring>
#include <random>

#include <gtest/gtest.h>

namespace gvx::store {
namespace {

std::vector<std::byte> smooth_bytes(std::size_t count) {
  std::mt19937 random(5);
  std::vector<std::byte> bytes(count);
  for (std::size_t i = 0; i < count; ++i) bytes[i] = static_cast<std::byte>(i / 37 + random() % 3);
  return bytes;
}

class EveryCodec : public testing::TestWithParam<std::tuple<Codec, std::size_t>> {};

INSTANTIATE_TEST_SUITE_P(, EveryCodec,
                         testing::Combine(testing::Values(Codec::none, Codec::zstd, Codec::lz4),
                                          testing::Values(1, 2, 4, 24)),
                         [](const auto& tested) {
                           return std::string(codec_name(std::get<0>(tested.param))) + "_" +
                                  std::to_string(std::get<1>(tested.param)) + "_bytes";
                         });

TEST_P(EveryCodec, gives_back_what_it_took) {
  const auto [codec, element] = GetParam();
  const auto raw = smooth_bytes(24 * 500);
  const BlockLayout layout{static_cast<std::size_t>(element), 240};  // and single bytes behind
  std::vector<std::byte> compressed, back(raw.size());
  compress(codec, layout, raw, compressed);
  if (codec != Codec::none) {
    EXPECT_LT(compressed.size(), raw.size());
  }
  ASSERT_TRUE(decompress(codec, layout, compressed, back).ok());
  EXPECT_EQ(back, raw);
}

TEST_P(EveryCodec, refuses_every_truncation_and_survives_flipped_bytes) {
  const auto [codec, element] = GetParam();
  const auto raw = smooth_bytes(24 * 40);
  const BlockLayout layout{static_cast<std::size_t>(element), 30};
  std::vector<std::byte> compressed, back(raw.size());
  compress(codec, layout, raw, compressed);
  for (std::size_t length = 0; length < compressed.size(); ++length) {
    ASSERT_FALSE(decompress(codec, layout, std::span(compressed).first(length), back).ok()) << length;
  }
  int refused = 0;
  for (std::size_t i = 0; i < compressed.size(); ++i) {
    auto damaged = compressed;
    damaged[i] ^= std::byte{0x41};
    refused += decompress(codec, layout, damaged, back).ok() ? 0 : 1;
  }
  if (codec == Codec::none) {
    EXPECT_EQ(refused, 0);
  }
}

TEST(Checksum, is_xxh3) {
  // The digest of the empty input that the xxHash specification gives for XXH3_64bits.
  EXPECT_EQ(checksum({}), 0x2d06800538d394c2ull);
}

}  // namespace
}  // namespace gvx::store
