#include "gvx/scene/transform_fields.h"

#include <string>
#include <vector>

#include "gvx/scene/scene_limits.h"

namespace gvx::scene {
namespace {

using Json = nlohmann::json;
using WrittenJson = nlohmann::ordered_json;

Vec3d vector_of(const std::vector<double>& row) {
  return {row[0], row[1], row[2]};
}

/// Three rows of four numbers; a fourth can only be that of an affine map.
void read_matrix(JsonFields& fields, std::optional<Affine3>& matrix) {
  const Json* value = fields.any("matrix");
  if (value == nullptr) return;
  const std::string place = fields.place_of("matrix");
  if (!value->is_array() || value->size() < 3 || value->size() > 4) {
    return fields.fail(place, "3 or 4 rows of 4 numbers", describe(*value));
  }
  const auto rows = fields.rows("matrix", {kAny, kAny, kAny, kAny});
  if (rows.size() != value->size()) return;  // which was told
  if (rows.size() == 4 && rows[3] != std::vector<double>{0, 0, 0, 1}) {
    fields.fail(place + "[3]", "[0,0,0,1]", (*value)[3].dump());
  }
  Affine3& map = matrix.emplace();
  for (int row = 0; row < 3; ++row) {
    const std::vector<double>& numbers = rows[static_cast<std::size_t>(row)];
    for (int i = 0; i < 3; ++i) map.column[i][row] = numbers[static_cast<std::size_t>(i)];
    map.origin[row] = numbers[3];
  }
}

Status read_rotation(const Json& value, const std::string& place, Rotation& rotation) {
  JsonFields fields(value, place);
  const auto axis = fields.row("axis", {kAny, kAny, kAny});
  const auto degrees = fields.number("degrees", kAny);
  GVX_TRY(fields.finish());
  if (!axis) return field_error(place + ".axis", "a list of 3 numbers", "nothing");
  if (!degrees) return field_error(place + ".degrees", "a number", "nothing");
  rotation = {vector_of(*axis), *degrees};
  if (!(length(rotation.axis) > 0)) return field_error(place + ".axis", "a direction", "[0,0,0]");
  return {};
}

void read_scale(JsonFields& fields, std::optional<Vec3d>& scale) {
  const Json* value = fields.any("scale");
  if (value == nullptr) return;
  if (value->is_array()) {
    if (const auto row = fields.row("scale", {kAny, kAny, kAny})) scale = vector_of(*row);
  } else if (const auto number = fields.number("scale", kAny)) {
    scale = Vec3d(*number);
  }
}

Status read_parts(const Json& value, const std::string& place, TransformParts& transform) {
  JsonFields fields(value, place);
  read_matrix(fields, transform.matrix);
  if (const auto row = fields.row("translate", {kAny, kAny, kAny})) transform.translate = vector_of(*row);
  if (const Json* rotation = fields.any("rotate")) {
    fields.take(read_rotation(*rotation, fields.place_of("rotate"), transform.rotate.emplace()));
  }
  read_scale(fields, transform.scale);
  if (transform.matrix && (transform.translate || transform.rotate || transform.scale)) {
    fields.fail(place, "matrix or translate, rotate and scale", "both");
  }
  GVX_TRY(fields.finish());
  if (check_placement(transform.to_world()).ok()) return {};
  return field_error(place, "a transform with an inverse", "one without");
}

WrittenJson list_of(Vec3d v) {
  return {v.x, v.y, v.z};
}

WrittenJson rows_of(const Affine3& map) {
  WrittenJson rows = WrittenJson::array();
  for (int row = 0; row < 3; ++row) {
    rows.push_back({map.column[0][row], map.column[1][row], map.column[2][row], map.origin[row]});
  }
  return rows;
}

}  // namespace

void read_transform(JsonFields& fields, TransformParts& transform) {
  const Json* value = fields.any("transform");
  if (value != nullptr) fields.take(read_parts(*value, fields.place_of("transform"), transform));
}

void write_transform(WrittenJson& object, const TransformParts& transform) {
  WrittenJson parts = WrittenJson::object();
  if (transform.matrix) parts["matrix"] = rows_of(*transform.matrix);
  if (transform.scale) parts["scale"] = list_of(*transform.scale);
  if (const auto& rotate = transform.rotate) {
    parts["rotate"] = {{"axis", list_of(rotate->axis)}, {"degrees", rotate->degrees}};
  }
  if (transform.translate) parts["translate"] = list_of(*transform.translate);
  if (!parts.empty()) object["transform"] = std::move(parts);
}

}  // namespace gvx::scene
