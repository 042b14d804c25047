/// \file
/// Those parts of a scene file that are more than a value: cameras, transfer functions, labels, lights.
/// Private to this room.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "gvx/scene/json_fields.h"
#include "gvx/scene/scene_file.h"

namespace gvx::scene {

/// Each reads the field or fields of its name from an object, and keeps errors there.
void read_camera(JsonFields& fields, CameraParts& camera);
void read_camera_path(JsonFields& fields, std::vector<KeyFrameParts>& path);
/// "functions", or "function" for a single one.
void read_functions(JsonFields& fields, std::vector<FunctionParts>& functions);
void read_labels(JsonFields& fields, std::optional<LabelParts>& labels);
void read_lights(JsonFields& fields, std::optional<std::vector<Light>>& lights);

/// The double of fewest digits that is this float: 0.2 for 0.2f.
double widened(float v);

/// Each writes the field that it is read from, unless there is nothing to say.
void write_camera(nlohmann::ordered_json& object, const CameraParts& camera);
void write_camera_path(nlohmann::ordered_json& object, const std::vector<KeyFrameParts>& path);
void write_functions(nlohmann::ordered_json& object, const std::vector<FunctionParts>& functions);
void write_labels(nlohmann::ordered_json& object, const std::optional<LabelParts>& labels);
void write_lights(nlohmann::ordered_json& object, const std::optional<std::vector<Light>>& lights);

}  // namespace gvx::scene
