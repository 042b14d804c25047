/// \file
/// The parts of stretch_batch.h that are compiled for one voxel type each: those that take longest to
/// compile. Private to this room.
#pragma once

#include "gvx/render/tile/stretch_batch.h"

namespace gvx::render {

/// Composites a batch, pre-integrated, of voxels of one type.
void composite_batch_u8(const FrameView& frame, StretchBatch& batch);
void composite_batch_u16(const FrameView& frame, StretchBatch& batch);
void composite_batch_f32(const FrameView& frame, StretchBatch& batch);

/// Composites a batch, post-classified, of voxels of one type.
void post_batch_u8(const FrameView& frame, StretchBatch& batch);
void post_batch_u16(const FrameView& frame, StretchBatch& batch);
void post_batch_f32(const FrameView& frame, StretchBatch& batch);

}  // namespace gvx::render
