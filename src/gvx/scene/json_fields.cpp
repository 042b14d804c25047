#include "gvx/scene/json_fields.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>

namespace gvx::scene {
namespace {

constexpr std::size_t kLongestText = 40;

std::string number_text(double v) {
  char text[32];
  return std::string(text, std::to_chars(text, text + sizeof(text), v).ptr);
}

/// In quotation marks, on one line and printable.
std::string in_quotes(std::string_view text) {
  std::string result = "'";
  for (const char c : text.substr(0, kLongestText)) result += c >= ' ' && c <= '~' ? c : '?';
  return result + (text.size() > kLongestText ? "...'" : "'");
}

std::string list_text(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

}  // namespace

bool NumberRange::contains(double v) const {
  const bool within = open ? v > least && v < most : v >= least && v <= most;
  return std::isfinite(v) && within && (!whole || v == std::floor(v));
}

std::string NumberRange::text() const {
  std::string number = whole ? "a whole number" : "a number";
  if (most < std::numeric_limits<double>::infinity()) {
    return number + (open ? " between " : " from ") + number_text(least) + (open ? " and " : " to ") +
           number_text(most);
  }
  if (std::isfinite(least)) return number + (open ? " above " : " of at least ") + number_text(least);
  return number;
}

std::string describe(const nlohmann::json& value) {
  if (value.is_string()) return in_quotes(value.get_ref<const std::string&>());
  if (value.is_array()) return "a list of " + std::to_string(value.size());
  if (value.is_object()) return "an object";
  return value.dump();
}

Error field_error(const std::string& place, const std::string& expected, const std::string& found) {
  return Error{(place.empty() ? "" : place + ": ") + "expected " + expected + ", found " + found};
}

JsonFields::JsonFields(const Json& object, std::string place) : object_(object), place_(std::move(place)) {
  if (!object.is_object()) fail(place_, "an object", describe(object));
}

std::string JsonFields::place_of(const char* name) const {
  return place_.empty() ? name : place_ + "." + name;
}

void JsonFields::fail(const std::string& place, const std::string& expected, const std::string& found) {
  take(field_error(place, expected, found));
}

void JsonFields::take(const Status& status) {
  if (!status.ok() && !error_) error_ = status.error().message;
}

const JsonFields::Json* JsonFields::any(const char* name) {
  known_.emplace_back(name);
  if (!object_.is_object()) return nullptr;
  const auto field = object_.find(name);
  return field == object_.end() ? nullptr : &*field;
}

const JsonFields::Json* JsonFields::list(const char* name) {
  const Json* value = any(name);
  if (value == nullptr || value->is_array()) return value;
  fail(place_of(name), "a list", describe(*value));
  return nullptr;
}

std::optional<bool> JsonFields::boolean(const char* name) {
  const Json* value = any(name);
  if (value == nullptr) return std::nullopt;
  if (value->is_boolean()) return value->get<bool>();
  fail(place_of(name), "true or false", describe(*value));
  return std::nullopt;
}

std::optional<std::string> JsonFields::text(const char* name) {
  const Json* value = any(name);
  if (value == nullptr) return std::nullopt;
  // Names of files end at a zero byte.
  const auto sound = [](const std::string& text) {
    return !text.empty() && text.find('\0') == std::string::npos;
  };
  if (value->is_string() && sound(value->get_ref<const std::string&>())) return value->get<std::string>();
  fail(place_of(name), "a text", describe(*value));
  return std::nullopt;
}

std::optional<double> JsonFields::number(const char* name, NumberRange range) {
  const Json* value = any(name);
  return value == nullptr ? std::nullopt : checked(*value, place_of(name), range);
}

std::optional<std::size_t> JsonFields::choice(const char* name, std::span<const char* const> names) {
  const Json* value = any(name);
  if (value == nullptr) return std::nullopt;
  const auto found = std::find_if(names.begin(), names.end(),
                                  [&](const char* n) { return value->is_string() && *value == n; });
  if (found != names.end()) return static_cast<std::size_t>(found - names.begin());
  fail(place_of(name), "one of " + list_text({names.begin(), names.end()}), describe(*value));
  return std::nullopt;
}

std::optional<std::vector<double>> JsonFields::row(const char* name,
                                                   const std::vector<NumberRange>& columns) {
  const Json* value = any(name);
  return value == nullptr ? std::nullopt : checked(*value, place_of(name), columns);
}

std::optional<Vec3dd> JsonFields::long_row(const char* name) {
  const Json* value = any(name);
  if (value == nullptr) return std::nullopt;
  Vec3dd row;
  for (std::size_t i = 0; i < 3; ++i) {
    const Json* number = value->is_array() && value->size() == 3 ? &(*value)[i] : value;
    const auto digits = number->is_string()   ? parse_double_double(number->get_ref<const std::string&>())
                        : number->is_number() ? std::optional<DoubleDouble>(number->get<double>())
                                              : std::nullopt;
    if (!digits) {
      fail(place_of(name), "a list of 3 numbers, or texts of digits", describe(*number));
      return std::nullopt;
    }
    row[static_cast<int>(i)] = *digits;
  }
  return row;
}

std::vector<std::vector<double>> JsonFields::rows(const char* name, const std::vector<NumberRange>& columns) {
  const Json* value = list(name);
  if (value == nullptr) return {};
  if (value->empty()) fail(place_of(name), "at least one point", "an empty list");
  std::vector<std::vector<double>> result;
  for (std::size_t i = 0; i < value->size() && !error_; ++i) {
    auto row = checked((*value)[i], place_of(name) + "[" + std::to_string(i) + "]", columns);
    if (row) result.push_back(std::move(*row));
  }
  return result;
}

std::optional<double> JsonFields::checked(const Json& value, const std::string& place,
                                          const NumberRange& range) {
  if (value.is_number() && range.contains(value.get<double>())) return value.get<double>();
  fail(place, range.text(), describe(value));
  return std::nullopt;
}

std::optional<std::vector<double>> JsonFields::checked(const Json& value, const std::string& place,
                                                       const std::vector<NumberRange>& columns) {
  if (!value.is_array() || value.size() != columns.size()) {
    fail(place, "a list of " + std::to_string(columns.size()) + " numbers", describe(value));
    return std::nullopt;
  }
  std::vector<double> numbers;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const auto number = checked(value[i], place + "[" + std::to_string(i) + "]", columns[i]);
    if (!number) return std::nullopt;
    numbers.push_back(*number);
  }
  return numbers;
}

Status JsonFields::finish() const {
  if (object_.is_object()) {
    for (const auto& field : object_.items()) {
      if (std::find(known_.begin(), known_.end(), field.key()) == known_.end()) {
        return field_error(place_, "fields among " + list_text(known_),
                           "the unknown field " + in_quotes(field.key()));
      }
    }
  }
  if (error_) return Error{*error_};
  return {};
}

}  // namespace gvx::scene
