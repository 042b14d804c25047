#include "gvx/engine/preview_pace.h"

#include <gtest/gtest.h>

namespace gvx::engine {
namespace {

TEST(PreviewPace, begins_with_the_smallest_block_that_half_a_budget_draws) {
  PreviewPace pace;
  EXPECT_EQ(pace.first_block(), render::Film::kLargestBlock);
  const auto share = [&](double of_single_pixels) {
    return of_single_pixels / (pace.first_block() * pace.first_block());
  };
  for (int frame = 0; frame < 100; ++frame) {
    pace.first_stage_took(share(10), false);
    EXPECT_LE(share(10), 1.2) << frame;
  }
  EXPECT_EQ(pace.first_block(), 8u);
  // Where all became fifty times as much, a few frames are late.
  int late = 0;
  for (int frame = 0; frame < 100; ++frame) {
    late += share(500) > 1 ? 1 : 0;
    pace.first_stage_took(share(500), false);
  }
  EXPECT_LE(late, 5);
  EXPECT_EQ(pace.first_block(), render::Film::kLargestBlock);
  for (int frame = 0; frame < 100; ++frame) pace.first_stage_took(0.01, false);
  EXPECT_EQ(pace.first_block(), 1u);
}

TEST(PreviewPace, does_not_trust_what_takes_little_because_there_is_little) {
  PreviewPace pace;
  for (int frame = 0; frame < 100; ++frame) pace.first_stage_took(0.01, true);
  EXPECT_EQ(pace.first_block(), render::Film::kLargestBlock);
}

TEST(PreviewPace, tries_smaller_blocks_seldom_where_they_take_too_long) {
  PreviewPace pace;
  int late = 0;
  for (int frame = 0; frame < 310; ++frame) {
    const bool fits = pace.first_block() >= 16;
    late += fits ? 0 : 1;
    pace.first_stage_took(fits ? 0.29 : 1.1, false);
  }
  EXPECT_LE(late, 11);
  EXPECT_GT(late, 0);
}

TEST(PreviewPace, wants_coarser_levels_while_frames_do_not_come_to_small_blocks) {
  PreviewPace pace;
  for (int frame = 0; frame < 10; ++frame) pace.frame_ended(8, true);
  EXPECT_EQ(pace.level_bias(), PreviewPace::kMostLevelBias);
  pace.frame_ended(2, true);
  EXPECT_EQ(pace.level_bias(), PreviewPace::kMostLevelBias);
  pace.frame_ended(0, true);
  EXPECT_EQ(pace.level_bias(), PreviewPace::kMostLevelBias - PreviewPace::kLevelBiasStep);
  for (int frame = 0; frame < 10; ++frame) pace.frame_ended(0, true);
  EXPECT_EQ(pace.level_bias(), 0);
  for (int frame = 0; frame < 10; ++frame) pace.frame_ended(8, false);
  EXPECT_EQ(pace.level_bias(), 0);
}

}  // namespace
}  // namespace gvx::engine
