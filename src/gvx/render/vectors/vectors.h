/// \file
/// Which of the vectors of stretch_batch.h gather from the batches of a frame. Private to this room.
#pragma once

#include "gvx/render/reference/gather.h"
#include "gvx/render/tile/stretch_batch.h"

namespace gvx::render {

/// None: one ray at a time does.
enum class Vectors {
  none,
  composite,
  composite_channels,
  composite_post,
  composite_classified,
  project,
  find_surface
};

inline Vectors vectors_for(const FrameView& frame) {
  if (frame.adds_noise) return Vectors::none;
  if (frame.format.content != VoxelContent::scalar) return Vectors::composite_classified;
  if (projects(frame)) return Vectors::project;
  if (frame.visibility.mode == scene::Mode::isosurface) return Vectors::find_surface;
  if (frame.classification == scene::Classification::post) return Vectors::composite_post;
  return frame.visibility.channels == 1 ? Vectors::composite : Vectors::composite_channels;
}

inline void gather_batch(Vectors vectors, const FrameView& frame, StretchBatch& batch) {
  switch (vectors) {
    case Vectors::none:
      return;
    case Vectors::composite:
      return composite_batch(frame, batch);
    case Vectors::composite_channels:
      return composite_channels_batch(frame, batch);
    case Vectors::composite_post:
      return composite_post_batch(frame, batch);
    case Vectors::composite_classified:
      return composite_classified_batch(frame, batch);
    case Vectors::project:
      return project_batch(frame, batch);
    case Vectors::find_surface:
      return find_surface_batch(frame, batch);
  }
}

}  // namespace gvx::render
