/// \file
/// PreviewRays: the preview of a picture, drawn in blocks of pixels that become finer, from what is in
/// memory. It knows how far it has come and when it is worth drawing anew.
#pragma once

#include <chrono>
#include <cstdint>

#include "gvx/engine/preview_pace.h"
#include "gvx/exec/buffer.h"
#include "gvx/exec/device.h"
#include "gvx/render/frame/film.h"
#include "gvx/render/march_pass.h"

namespace gvx::engine {

class PreviewRays {
 public:
  /// Of a film of this grid.
  PreviewRays(const exec::Device& device, exec::TileGrid grid);

  /// A new view's preview begins with blocks of this size.
  void begin_view(std::uint32_t first_block);
  /// Draws anew, from the first blocks on.
  void begin_again() { begin(first_block_); }
  /// A picture that is drawn is drawn anew, in single pixels: there is no hurry.
  void begin_refresh();

  /// The size of the blocks that are drawn now; 0: all is drawn.
  std::uint32_t block() const { return block_; }
  bool complete() const { return block_ == 0; }
  /// Are these the first blocks of their preview?
  bool in_first_stage() const { return block_ == first_block_; }
  /// A preview's stages up to this one, in pixels, are drawn again while much data comes in.
  static constexpr std::uint32_t kCoarseBlock = 8;
  bool coarse() const { return !complete() && (in_first_stage() || block_ >= kCoarseBlock); }

  /// Has a first stage of this view been drawn?
  bool shows_something() const { return shows_something_; }
  /// How long the last first stage took.
  std::chrono::nanoseconds first_stage_took() const { return first_stage_took_; }

  /// Draws the next few tiles; false where the deadline cut them off.
  bool draw(render::Film& film, const render::Pass& pass, exec::Deadline deadline);
  /// Draws the rest of the blocks of this size; false where the deadline cut them off. A view's first stage
  /// is the small unit of work that is done in any case: a frame always shows something.
  bool draw_stage(render::Film& film, const render::Pass& pass, exec::Deadline deadline);
  /// Draws stages, some tiles in any case, until the deadline or until all is drawn.
  void draw_until(render::Film& film, const render::Pass& pass, exec::Deadline deadline);

  /// Did coarse blocks want much that was not there?
  bool lacks_much(const render::Film& film) const;

 private:
  void begin(std::uint32_t first_block);

  exec::Device device_;
  exec::Buffer<std::uint32_t> list_;
  std::uint32_t generation_ = 0;
  std::uint32_t first_block_ = 0;  // of its first stage; of a refresh 0, which no stage has
  std::uint32_t block_ = 0;
  std::uint32_t tile_ = 0;  // the first that is not drawn
  bool shows_something_ = false;
  std::chrono::nanoseconds first_stage_took_{0};
};

}  // namespace gvx::engine
