#include "gvx/io/value_survey.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

namespace gvx::io {
namespace {

/// Samples in memory, of one row a slice.
template <typename Sample>
class Samples final : public SliceReader {
 public:
  Samples(SampleType type, std::vector<Sample> samples, int components = 1) : samples_(std::move(samples)) {
    description_.type = type;
    description_.components = components;
    const auto voxels = static_cast<std::int64_t>(samples_.size()) / components;
    description_.dimensions = voxels % 100 == 0 ? Vec3i(10, 10, voxels / 100) : Vec3i(1, 1, voxels);
  }
  VolumeDescription description_;

  const VolumeDescription& description() const override { return description_; }
  Status read_slices(std::int64_t count, std::span<std::byte> out) override {
    std::memcpy(out.data(),
                reinterpret_cast<const std::byte*>(samples_.data()) +
                    static_cast<std::uint64_t>(next_) * slice_bytes(description_),
                out.size());
    next_ += count;
    return {};
  }
  std::int64_t next_slice() const override { return next_; }
  Status rewind() override {
    next_ = 0;
    return {};
  }
  bool can_rewind() const override { return true; }

 private:
  std::vector<Sample> samples_;
  std::int64_t next_ = 0;
};

std::uint64_t sum(const std::vector<std::uint64_t>& counts) {
  return std::accumulate(counts.begin(), counts.end(), std::uint64_t{0});
}

TEST(ValueSurvey, of_narrow_samples_is_exact) {
  std::vector<std::int16_t> samples;
  for (int i = 0; i < 10000; ++i) samples.push_back(static_cast<std::int16_t>(i - 5000));
  Samples<std::int16_t> reader(SampleType::i16, samples);
  std::uint64_t told = 0;
  const auto summary = survey_values(reader, [&](std::uint64_t done, std::uint64_t all) {
    told = done;
    EXPECT_EQ(all, 20000u);
  });
  ASSERT_TRUE(summary.ok());
  const ValueSummary& s = summary.value().at(0);
  EXPECT_EQ(told, 20000u);
  EXPECT_EQ(s.numbers, 10000u);
  EXPECT_EQ(s.minimum, -5000);
  EXPECT_EQ(s.maximum, 4999);
  // The 10th, 100th, 5000th, 9900th and 9990th number.
  EXPECT_EQ(s.percentiles, (std::array<double, 5>{-4991, -4901, -1, 4899, 4989}));
  EXPECT_EQ(sum(s.histogram), 10000u);
  EXPECT_NEAR(double(s.histogram[100]), 10000.0 / 256, 1.5);
  EXPECT_FALSE(s.distinct.has_value());
}

TEST(ValueSurvey, of_wide_samples_is_close_and_counts_what_is_no_number) {
  std::vector<float> samples;
  for (int i = 0; i < 10000; ++i) samples.push_back(0.01f * static_cast<float>(i) - 20);
  samples[17] = NAN;
  samples[18] = std::numeric_limits<float>::infinity();
  Samples<float> reader(SampleType::f32, samples);
  reader.description_.scale = -2;  // turns the order round
  reader.description_.offset = 1;
  const ValueSummary s = survey_values(reader, {}).value().at(0);
  EXPECT_EQ(s.numbers, 9998u);
  EXPECT_EQ(s.not_finite, 2u);
  EXPECT_NEAR(s.minimum, 1 - 2 * 79.99, 1e-4);
  EXPECT_NEAR(s.maximum, 41, 1e-4);
  EXPECT_NEAR(s.percentiles[2], 1 - 2 * 30.0, 0.3);
  EXPECT_NEAR(s.percentiles[3], 41 - 2 * 1.0, 0.3);
  EXPECT_EQ(sum(s.histogram), 9998u);
  EXPECT_NEAR(double(s.histogram[40]), 10000.0 / 256, 6);
}

TEST(ValueSurvey, tells_values_that_are_few) {
  std::vector<double> samples(1000, 0.5);
  samples[3] = -7;
  samples[500] = 1e300;
  Samples<double> reader(SampleType::f64, samples);
  const ValueSummary s = survey_values(reader, {}).value().at(0);
  EXPECT_EQ(s.distinct, (std::vector<double>{-7, 0.5, 1e300}));
  EXPECT_EQ(s.percentiles, (std::array<double, 5>{-7, 0.5, 0.5, 0.5, 0.5}));

  Samples<std::uint8_t> labels(SampleType::u8, std::vector<std::uint8_t>{3, 0, 3, 9, 0, 0});
  EXPECT_EQ(survey_values(labels, {}).value().at(0).distinct, (std::vector<double>{0, 3, 9}));
}

TEST(ValueSurvey, is_of_each_component) {
  std::vector<std::uint16_t> samples;
  for (int i = 0; i < 500; ++i)
    samples.insert(samples.end(), {std::uint16_t(i), 7, std::uint16_t(60000 + i)});
  Samples<std::uint16_t> reader(SampleType::u16, samples, 3);
  const auto summaries = survey_values(reader, {}).value();
  ASSERT_EQ(summaries.size(), 3u);
  EXPECT_EQ(summaries[0].maximum, 499);
  EXPECT_EQ(summaries[1].distinct, (std::vector<double>{7}));
  EXPECT_EQ(sum(summaries[1].histogram), 500u);
  EXPECT_EQ(summaries[2].minimum, 60000);
}

TEST(ValueSurvey, of_nothing_but_no_data_has_no_range) {
  Samples<float> reader(SampleType::f32, std::vector<float>(100, NAN));
  const ValueSummary s = survey_values(reader, {}).value().at(0);
  EXPECT_EQ(s.numbers, 0u);
  EXPECT_EQ(s.not_finite, 100u);
  EXPECT_TRUE(s.histogram.empty());
}

TEST(ValueSurvey, of_bins_that_tell_each_value_is_exact) {
  // As a store counts u8 values from 10 to 13.
  std::vector<std::uint64_t> bins(1024);
  for (const auto& [value, count] : {std::pair{10, 50u}, {11, 30u}, {13, 20u}}) {
    bins[static_cast<std::size_t>(std::min((value - 10) * 1024 / 3, 1023))] = count;
  }
  const ValueSummary s = summary_of_bins({10, 13}, bins, 100, true, 2, 100);
  EXPECT_EQ(s.distinct, (std::vector<double>{120, 122, 126}));
  EXPECT_EQ(s.percentiles[2], 120);
  EXPECT_EQ(s.percentiles[3], 126);
  EXPECT_EQ(s.numbers, 100u);
  EXPECT_EQ(s.not_finite, 0u);
}

TEST(ValueSurvey, of_wide_bins_lies_within_them) {
  const std::vector<std::uint64_t> bins(1024, 10);
  const ValueSummary s = summary_of_bins({0, 65535}, bins, 10300, true, 1, 0);
  EXPECT_NEAR(s.percentiles[2], 32767, 64);
  EXPECT_EQ(s.not_finite, 60u);
  EXPECT_FALSE(s.distinct.has_value());
}

}  // namespace
}  // namespace gvx::io
