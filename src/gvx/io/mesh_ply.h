/// \file
/// PLY, the format of scanned surfaces (Turk 1994): as text or binary in either byte order, also with gzip.
/// Read in one pass; nothing is held but what waits for the sink.
#pragma once

#include <string>

#include "gvx/io/mesh.h"

namespace gvx::io {

/// Vertices' x, y, z and, if there are, red, green, blue; faces' vertex_indices, cut into fans. What else
/// there is is passed over.
Status stream_ply(const std::string& path, MeshSink& sink, const MeshProgress& progress);

}  // namespace gvx::io
