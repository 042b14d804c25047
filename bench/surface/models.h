// The meshes that the bench of surfaces draws: a file's, or a bumpy sphere, cut into as many triangles as are
// asked for, with detail as fine as these.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "gvx/core/ray.h"
#include "gvx/core/result.h"
#include "gvx/core/up_axis.h"
#include "gvx/exec/device.h"
#include "gvx/io/mesh.h"
#include "gvx/mesh/mesh_spool.h"

namespace gvx::bench {

struct Model {
  std::vector<Vec3f> places, normals, colors;  ///< of vertices; there is memory for one more than there are
  std::vector<io::Triangle> triangles;
  Box3d bounds;
  UpAxis up = UpAxis::z;

  std::uint64_t bytes() const {
    return 3 * sizeof(Vec3f) * places.size() + sizeof(io::Triangle) * triangles.size();
  }
};

/// About so many triangles of a mesh file, or of a bumpy sphere where `path` is empty. Each triangle of the
/// file is cut into four until their number is nearest to that, as a ratio. New vertices are moved along the
/// normal by a little noise.
Result<Model> make_model(const exec::Device& cpu, const std::string& path, double triangles);

/// The same as if it were read from a file.
Result<std::unique_ptr<mesh::MeshSpool>> spooled(const Model& model, const std::string& folder,
                                                 std::uint64_t memory_bytes);

}  // namespace gvx::bench
