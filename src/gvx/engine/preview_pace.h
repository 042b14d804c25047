/// \file
/// PreviewPace: with what previews of a moving camera begin, so that frames end in time and yet show most.
#pragma once

#include <cstdint>

#include "gvx/render/frame/film.h"

namespace gvx::engine {

/// Learns from frame to frame. A first stage of smaller blocks leaves out the coarser ones, whose rays stand
/// so far apart that they share nothing; coarser levels are for frames that do not come to small blocks.
class PreviewPace {
 public:
  /// The block of the first stage, which is drawn however long it takes.
  std::uint32_t first_block() const { return first_block_; }
  /// By how many levels previews want less than the exact picture.
  double level_bias() const { return level_bias_; }

  /// The first stage took this share of the frame's budget. Where rays lacked much they will take longer.
  void first_stage_took(double share, bool lacked_much);
  /// A view's first frame ended in a stage of this block; 0: it drew all.
  void frame_ended(std::uint32_t block, bool adapts_levels);

  /// A view that was drawn in blocks of this many pixels is at rest: exact rays begin, which cost no more
  /// than finer blocks. Frames that do not come so far want coarser levels.
  static constexpr std::uint32_t kRestBlock = 4;
  static constexpr double kMostLevelBias = 1, kLevelBiasStep = 0.25;

 private:
  std::uint32_t first_block_ = render::Film::kLargestBlock;
  int until_finer_ = 0;  // so many more frames before smaller blocks are tried
  double level_bias_ = 0;
};

}  // namespace gvx::engine
