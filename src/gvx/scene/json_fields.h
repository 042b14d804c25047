/// \file
/// JsonFields: the fields of one JSON object, asked for by name. Keeps what is wrong first, as one line that
/// says where in the document, what was expected and what was found.
#pragma once

#include <initializer_list>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "gvx/core/double_double.h"
#include "gvx/core/result.h"

namespace gvx::scene {

struct NumberRange {
  double least = -std::numeric_limits<double>::infinity();
  double most = std::numeric_limits<double>::infinity();
  bool whole = false;
  bool open = false;  ///< least and most themselves are out of range

  bool contains(double v) const;
  /// "a whole number from 1 to 8".
  std::string text() const;
};

class JsonFields {
 public:
  using Json = nlohmann::json;

  /// `place` is where the object stands, such as "lighting.lights[2]"; empty for the whole document.
  JsonFields(const Json& object, std::string place);

  /// The value of a field, or nothing where it is not there or wrong, which finish() tells.
  std::optional<bool> boolean(const char* name);
  std::optional<std::string> text(const char* name);
  std::optional<double> number(const char* name, NumberRange range);
  /// The index of the text in `names`.
  std::optional<std::size_t> choice(const char* name, std::span<const char* const> names);
  /// As many numbers as there are ranges.
  std::optional<std::vector<double>> row(const char* name, const std::vector<NumberRange>& columns);
  /// Three numbers, or texts of more digits than a double has.
  std::optional<Vec3dd> long_row(const char* name);
  /// A list of at least one row.
  std::vector<std::vector<double>> rows(const char* name, const std::vector<NumberRange>& columns);
  /// A list of anything; null where it is not there.
  const Json* list(const char* name);
  /// Anything; null where it is not there.
  const Json* any(const char* name);

  /// Where the field stands in the document.
  std::string place_of(const char* name) const;
  /// Keeps an error of what stands in a field; the first one counts.
  void fail(const std::string& place, const std::string& expected, const std::string& found);
  void take(const Status& status);
  /// To be called after every field was asked for: what was wrong, or a field that is not known.
  Status finish() const;

 private:
  std::optional<double> checked(const Json& value, const std::string& place, const NumberRange& range);
  std::optional<std::vector<double>> checked(const Json& value, const std::string& place,
                                             const std::vector<NumberRange>& columns);

  const Json& object_;
  std::string place_;
  std::vector<std::string> known_;
  std::optional<std::string> error_;
};

/// "PLACE: expected EXPECTED, found FOUND"; for the whole document without a place.
Error field_error(const std::string& place, const std::string& expected, const std::string& found);

/// For "found": short and printable.
std::string describe(const nlohmann::json& value);

}  // namespace gvx::scene
