/// \file
/// From a scene and an open volume to what is rendered, but for the choice of cameras.
#pragma once

#include "gvx/core/result.h"
#include "gvx/open/open_volume.h"
#include "gvx/open/options.h"
#include "gvx/render/frame/view.h"
#include "gvx/scene/scene_file.h"

namespace gvx::open {

/// An error where the mode lacks an isovalue. `volume_values` is what is said of the volume's, if anything.
Status check_isovalue(const scene::ObjectParts& scene, const FieldNaming& naming,
                      const std::string& volume_values = "");

/// Chooses all that a scene leaves out to suit the volume, but for the cameras.
Status complete_look(scene::SceneFile& scene, const OpenVolume& volume, const FieldNaming& naming);

/// Of a scene that leaves nothing out.
Result<render::View> make_view(const scene::SceneFile& scene, const OpenVolume& volume,
                               const FieldNaming& naming);

}  // namespace gvx::open
