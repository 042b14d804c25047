/// \file
/// Field: a row of the table of a scene's fields, and the kinds of rows. Private to this room.
#pragma once

#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "gvx/core/ray.h"
#include "gvx/core/vec.h"
#include "gvx/scene/json_fields.h"
#include "gvx/scene/scene_fields.h"

namespace gvx::scene {

/// Keeps the order in which fields are written.
using WrittenJson = nlohmann::ordered_json;

/// How a field of Parts is read from an object of a scene file, written to one, and described.
template <typename Parts>
struct Field {
  FieldDescription about;
  std::function<void(JsonFields&, Parts&)> read;  ///< leaves what the object does not say as it is
  std::function<void(WrittenJson&, const Parts&)> write;
  std::vector<FieldDescription> inner = {};  ///< of an object: its own fields
};

template <typename Parts>
using FieldTable = std::vector<Field<Parts>>;

template <typename Parts>
void read_fields(JsonFields& fields, const FieldTable<Parts>& table, Parts& parts) {
  for (const Field<Parts>& field : table) field.read(fields, parts);
}

template <typename Parts>
void write_fields(WrittenJson& object, const FieldTable<Parts>& table, const Parts& parts) {
  for (const Field<Parts>& field : table) field.write(object, parts);
}

/// A number between limits.
template <typename Parts, typename Number>
Field<Parts> number(const char* name, std::optional<Number> Parts::*member, NumberRange range,
                    FlagText flag = {}) {
  return {{name, range.whole ? FieldForm::whole : FieldForm::number, flag, {}, range},
          [=](JsonFields& fields, Parts& parts) {
            if (const auto value = fields.number(name, range)) parts.*member = static_cast<Number>(*value);
          },
          [=](WrittenJson& object, const Parts& parts) {
            if (parts.*member) object[name] = *(parts.*member);
          }};
}

template <typename Parts>
Field<Parts> yes_or_no(const char* name, std::optional<bool> Parts::*member, FlagText flag = {}) {
  return {{name, FieldForm::yes_or_no, flag},
          [=](JsonFields& fields, Parts& parts) {
            if (const auto value = fields.boolean(name)) parts.*member = value;
          },
          [=](WrittenJson& object, const Parts& parts) {
            if (parts.*member) object[name] = *(parts.*member);
          }};
}

template <typename Parts>
Field<Parts> text(const char* name, std::optional<std::string> Parts::*member, FlagText flag = {}) {
  return {{name, FieldForm::text, flag},
          [=](JsonFields& fields, Parts& parts) {
            if (auto value = fields.text(name)) parts.*member = std::move(value);
          },
          [=](WrittenJson& object, const Parts& parts) {
            if (parts.*member) object[name] = *(parts.*member);
          }};
}

/// One of `names`: kept as its text, or as the enumerator or bool of its place among them.
template <typename Parts, typename Value>
Field<Parts> choice(const char* name, std::optional<Value> Parts::*member, std::span<const char* const> names,
                    FlagText flag = {}) {
  constexpr bool kIsText = std::is_same_v<Value, std::string>;
  return {{name, FieldForm::choice, flag, names},
          [=](JsonFields& fields, Parts& parts) {
            const auto place = fields.choice(name, names);
            if (!place) return;
            if constexpr (kIsText) {
              parts.*member = names[*place];
            } else {
              parts.*member = static_cast<Value>(*place);
            }
          },
          [=](WrittenJson& object, const Parts& parts) {
            if (!(parts.*member)) return;
            if constexpr (kIsText) {
              object[name] = *(parts.*member);
            } else {
              object[name] = names[static_cast<std::size_t>(*(parts.*member))];
            }
          }};
}

inline void take_row(const std::vector<double>& row, Vec3d& value) {
  value = {row[0], row[1], row[2]};
}
inline void take_row(const std::vector<double>& row, Vec3i& value) {
  value = Vec3i(Vec3d(row[0], row[1], row[2]));
}
inline void take_row(const std::vector<double>& row, Box3d& value) {
  value = {{row[0], row[1], row[2]}, {row[3], row[4], row[5]}};
}
inline WrittenJson row_of(Vec3d v) {
  return {v.x, v.y, v.z};
}
inline WrittenJson row_of(Vec3i v) {
  return {v.x, v.y, v.z};
}
inline WrittenJson row_of(const Box3d& b) {
  return {b.minimum.x, b.minimum.y, b.minimum.z, b.maximum.x, b.maximum.y, b.maximum.z};
}

/// A list of three numbers, or of the six of a box, each between the same limits.
template <typename Parts, typename Row>
Field<Parts> numbers(const char* name, std::optional<Row> Parts::*member, NumberRange each,
                     FlagText flag = {}) {
  const std::vector<NumberRange> columns(std::is_same_v<Row, Box3d> ? 6 : 3, each);
  return {{name, FieldForm::numbers, flag, {}, each, columns.size()},
          [=](JsonFields& fields, Parts& parts) {
            const auto row = fields.row(name, columns);
            if (row) take_row(*row, (parts.*member).emplace());
          },
          [=](WrittenJson& object, const Parts& parts) {
            if (parts.*member) object[name] = row_of(*(parts.*member));
          }};
}

/// An object with fields of its own.
template <typename Parts, typename Inner>
Field<Parts> object(const char* name, Inner Parts::*member, const FieldTable<Inner>& table) {
  Field<Parts> field{{name, FieldForm::other},
                     [=, &table](JsonFields& fields, Parts& parts) {
                       const nlohmann::json* value = fields.any(name);
                       if (value == nullptr) return;
                       JsonFields inner(*value, fields.place_of(name));
                       read_fields(inner, table, parts.*member);
                       fields.take(inner.finish());
                     },
                     [=, &table](WrittenJson& object, const Parts& parts) {
                       WrittenJson inner = WrittenJson::object();
                       write_fields(inner, table, parts.*member);
                       if (!inner.empty()) object[name] = std::move(inner);
                     }};
  for (const Field<Inner>& row : table) {
    field.inner.push_back(row.about);
    field.inner.back().path = std::string(name) + "." + row.about.path;
  }
  return field;
}

/// The items of a list, each read by `read(value, place)`, which returns a Result.
template <typename Item, typename Read>
void read_items(JsonFields& fields, const char* name, std::vector<Item>& items, Read read) {
  const nlohmann::json* list = fields.list(name);
  if (list == nullptr) return;
  items.clear();
  for (std::size_t i = 0; i < list->size(); ++i) {
    auto value = read((*list)[i], fields.place_of(name) + "[" + std::to_string(i) + "]");
    if (!value.ok()) return fields.take(value.error());
    items.push_back(std::move(value).value());
  }
}

/// A field that is read and written in a way of its own.
template <typename Parts>
Field<Parts> custom(const char* name, std::type_identity_t<std::function<void(JsonFields&, Parts&)>> read,
                    std::type_identity_t<std::function<void(WrittenJson&, const Parts&)>> write,
                    FlagText flag = {}, FieldForm form = FieldForm::other) {
  return {{name, form, flag}, std::move(read), std::move(write)};
}

}  // namespace gvx::scene
