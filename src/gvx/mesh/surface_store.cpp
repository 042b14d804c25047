#include "gvx/mesh/surface_store.h"

#include <algorithm>

#include "gvx/surface/surface_writer.h"

namespace gvx::mesh {

Result<SurfaceStoreReport> build_surface_store(const MeshSpool& mesh, const std::string& path,
                                               const SurfaceStoreOptions& options,
                                               const SurfaceProgress& progress) {
  const Box3d& box = mesh.summary().bounds;
  const double size = max_component(box.maximum - box.minimum);
  if (!(size > 1e-30 && size < 1e30)) {
    return Error{options.source + ": the mesh has no size that a surface can have, 1e-30 to 1e30"};
  }
  GVX_ASSIGN(const double cell, cell_of(mesh));
  const SurfaceSpace space = surface_space(mesh.summary(), cell);
  surface::SurfaceInfo info;
  info.levels = space.finest_level + 1;
  info.cells_to_world = scaling(Vec3d(space.cell));
  info.cells_to_world.origin = space.origin;
  info.bounds = {(box.minimum - space.origin) / space.cell, (box.maximum - space.origin) / space.cell};
  info.triangles = mesh.summary().triangles;
  info.up = options.up;
  info.codec = options.codec;
  info.source = options.source;
  GVX_ASSIGN(const auto writer, surface::SurfaceWriter::create(path, info.levels, options.codec));
  GVX_TRY(build_surface(
      mesh, space, options.memory_bytes,
      [&](const surface::SurfacePyramid::Made& brick) { return writer->add(brick); }, progress));
  GVX_TRY(writer->finish(info));
  return SurfaceStoreReport{info.levels, writer->bricks(), writer->samples(), space.cell,
                            writer->bytes_written()};
}

}  // namespace gvx::mesh
