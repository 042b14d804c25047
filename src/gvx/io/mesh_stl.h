/// \file
/// STL, the format of 3D printers and mills (3D Systems 1988), as text or binary. Read in one pass.
#pragma once

#include <string>

#include "gvx/io/mesh.h"

namespace gvx::io {

/// The corners of facets and, of binary files, their colours as VisCAM or Materialise Magics write them.
Status stream_stl(const std::string& path, MeshSink& sink, const MeshProgress& progress);

}  // namespace gvx::io
