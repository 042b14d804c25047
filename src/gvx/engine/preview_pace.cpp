#include "gvx/engine/preview_pace.h"

#include <algorithm>

#include "gvx/render/frame/film.h"

namespace gvx::engine {
namespace {

// Half a block takes up to four times as long, mostly twice: the first stage is to stay below half a budget.
constexpr double kMostOfBudget = 0.5, kFinerBelow = 0.3;
// Frames between a first stage that took too long and the next try.
constexpr int kCaution = 30;

}  // namespace

void PreviewPace::first_stage_took(double share, bool lacked_much) {
  if (share > kMostOfBudget) {
    first_block_ = std::min(2 * first_block_, render::Film::kLargestBlock);
    until_finer_ = kCaution;
  } else if (until_finer_ > 0) {
    --until_finer_;
  } else if (share < kFinerBelow && !lacked_much) {
    first_block_ = std::max(first_block_ / 2, 1u);
  }
}

void PreviewPace::frame_ended(std::uint32_t block, bool adapts_levels) {
  if (!adapts_levels) return;
  if (block >= kRestBlock) level_bias_ = std::min(level_bias_ + kLevelBiasStep, kMostLevelBias);
  if (block == 0) level_bias_ = std::max(level_bias_ - kLevelBiasStep, 0.0);
}

}  // namespace gvx::engine
