/// \file
/// Result<T>: a value, or an Error that says in one line what went wrong. Functions return it if files,
/// networks, arguments or missing devices can make them fail. GVX_CHECK is for mistakes in the program
/// itself.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "gvx/core/macros.h"

namespace gvx {

/// One line for a person: the file or argument, the field, and what was expected.
struct Error {
  std::string message;
};

/// A T or an Error. value() ends the program if there is an error, and error() if there is a value: ask ok()
/// first.
template <typename T>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}
  Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}

  bool ok() const { return state_.index() == 0; }
  explicit operator bool() const { return ok(); }

  const T& value() const& { return checked(std::get_if<0>(&state_)); }
  T& value() & { return checked(std::get_if<0>(&state_)); }
  T&& value() && { return std::move(checked(std::get_if<0>(&state_))); }
  const Error& error() const { return checked(std::get_if<1>(&state_)); }

 private:
  template <typename P>
  static P& checked(P* pointer) {
    GVX_CHECK(pointer != nullptr);
    return *pointer;
  }

  std::variant<T, Error> state_;
};

/// Success or an Error.
template <>
class [[nodiscard]] Result<void> {
 public:
  Result() = default;
  Result(Error error) : error_(std::move(error)) {}

  bool ok() const { return !error_.has_value(); }
  explicit operator bool() const { return ok(); }
  const Error& error() const {
    GVX_CHECK(error_.has_value());
    return *error_;
  }

 private:
  std::optional<Error> error_;
};

using Status = Result<void>;

}  // namespace gvx

#define GVX_CONCAT_INNER(a, b) a##b
#define GVX_CONCAT(a, b) GVX_CONCAT_INNER(a, b)

/// Evaluates a Status. If it is an error, returns it from the calling function.
#define GVX_TRY(expression)                                 \
  do {                                                      \
    if (auto gvx_status = (expression); !gvx_status.ok()) { \
      return ::gvx::Error(gvx_status.error());              \
    }                                                       \
  } while (false)

/// Evaluates a Result. Declares `declaration` with its value; if it is an error, returns it from the calling
/// function.
#define GVX_ASSIGN(declaration, expression) \
  GVX_ASSIGN_IMPL(GVX_CONCAT(gvx_result_, __LINE__), declaration, expression)
#define GVX_ASSIGN_IMPL(result, declaration, expression) \
  auto result = (expression);                            \
  if (!result.ok()) return ::gvx::Error(result.error()); \
  declaration = std::move(result).value()
