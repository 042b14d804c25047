/// \file
/// A transform in a scene file. Private to this room.
#pragma once

#include <nlohmann/json.hpp>

#include "gvx/scene/json_fields.h"
#include "gvx/scene/transform_parts.h"

namespace gvx::scene {

/// Reads the field "transform" of an object; keeps an error there, also where the transform has no usable
/// inverse.
void read_transform(JsonFields& fields, TransformParts& transform);

/// Writes the field, unless there is nothing to say.
void write_transform(nlohmann::ordered_json& object, const TransformParts& transform);

}  // namespace gvx::scene
