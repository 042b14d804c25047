/// \file
/// glTF 2.0, the Khronos format of scenes: .gltf with buffers in or beside it, or .glb. Whole in memory while
/// it is read.
#pragma once

#include <string>

#include "gvx/io/mesh.h"

namespace gvx::io {

/// The triangles of the scene's meshes, each where its nodes put it. Colours are COLOR_0 times the material's
/// base colour, converted from linear light to display values. Understands KHR_mesh_quantization; other
/// required extensions that change shapes are errors that name them. Skins and morph targets stay at rest.
Status stream_gltf(const std::string& path, MeshSink& sink, const MeshProgress& progress);

}  // namespace gvx::io
