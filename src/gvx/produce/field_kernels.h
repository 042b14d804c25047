/// \file
/// Fields as kernels: producers whose bricks and bounds a device makes, and which stay there.
#pragma once

#include <memory>
#include <vector>

#include "gvx/exec/device.h"
#include "gvx/produce/hypertexture.h"
#include "gvx/produce/producer.h"
#include "gvx/produce/terrain.h"

namespace gvx::produce {

/// The densities of HypertextureField around BallsField, such as a cumulus; `tree` as FieldProducer takes it.
std::shared_ptr<const Producer> make_balls_producer(const exec::Device& device, const TreeDescription& tree,
                                                    const std::vector<BallsField::Ball>& balls,
                                                    const HypertextureOptions& options);

/// The shares of ground of TerrainField.
std::shared_ptr<const Producer> make_terrain_producer(const exec::Device& device, const TreeDescription& tree,
                                                      const TerrainOptions& options);

}  // namespace gvx::produce
