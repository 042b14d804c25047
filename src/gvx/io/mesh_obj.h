/// \file
/// OBJ, Wavefront's text format of surfaces. Read in two passes, first the vertices: faces may stand before
/// them.
#pragma once

#include <string>

#include "gvx/io/mesh.h"

namespace gvx::io {

/// Vertices, with the colours that some programs write behind their places; faces, with the diffuse colours
/// of their materials where vertices have none. Curved surfaces, points and lines are left out.
Status stream_obj(const std::string& path, MeshSink& sink, const MeshProgress& progress);

}  // namespace gvx::io
