/// \file
/// open_temporary_store: the store that a volume or mesh file of another program becomes while it is shown.
#pragma once

#include <memory>
#include <string>

#include "gvx/core/result.h"
#include "gvx/io/volume_options.h"
#include "gvx/open/options.h"
#include "gvx/scene/scene_file.h"
#include "gvx/store/store_reader.h"
#include "gvx/surface/surface_reader.h"

namespace gvx::open {

/// Builds a store without a name in the folder for temporary files, so that nothing is left behind however
/// the process ends. `parts` say how a mesh becomes voxels; an error where one of them does not apply.
Result<std::unique_ptr<store::StoreReader>> open_temporary_store(const std::string& path,
                                                                 const io::VolumeOptions& volume_options,
                                                                 scene::GenerateParts parts,
                                                                 const OpenOptions& options);

/// The same of a mesh's surface.
Result<std::unique_ptr<surface::SurfaceReader>> open_temporary_surface(const std::string& path,
                                                                       const OpenOptions& options);

/// An error where something is said of a scene that it does not take: `left` is what nothing took.
Status check_all_taken(const std::string& name, const scene::GenerateParts& left);

}  // namespace gvx::open
