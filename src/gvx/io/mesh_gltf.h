/// \file
/// glTF 2.0, the Khronos format of scenes: .gltf with buffers in or beside it, or .glb. Whole in memory while
/// it is read.
#pragma once

#include <string>

#include "gvx/io/mesh.h"

namespace gvx::io {

/// The triangles of the scene's meshes, each where its nodes put it, with COLOR_0 times the material's base
/// colour, which are linear light, as displayed. Understands KHR_mesh_quantization. An error that names what
/// it is where the file requires an extension that changes shapes. Skins and morph targets are left at rest.
Status stream_gltf(const std::string& path, MeshSink& sink, const MeshProgress& progress);

}  // namespace gvx::io
