/// \file
/// make_balls_producer: hypertexture around balls, such as a cumulus, made by kernels on a device.
#pragma once

#include <memory>
#include <vector>

#include "gvx/exec/device.h"
#include "gvx/produce/hypertexture.h"
#include "gvx/produce/producer.h"

namespace gvx::produce {

/// The densities of HypertextureField around BallsField; `tree` as FieldProducer takes it.
std::shared_ptr<const Producer> make_balls_producer(const exec::Device& device, const TreeDescription& tree,
                                                    const std::vector<BallsField::Ball>& balls,
                                                    const HypertextureOptions& options);

}  // namespace gvx::produce
