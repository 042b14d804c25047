/// \file
/// The files that a mesh is spread over: materials beside an OBJ, buffers and pictures beside a glTF.
#pragma once

#include <string>
#include <vector>

namespace gvx::io {

/// `path`, and the files that it names, whether they are there or not. What cannot be read names none.
std::vector<std::string> mesh_files(const std::string& path);

}  // namespace gvx::io
