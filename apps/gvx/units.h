/// \file
/// Numbers with units, as people type and read them.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "gvx/core/result.h"
#include "gvx/core/vec.h"

namespace gvx::app {

/// An error of what a flag says names the flag.
template <typename Value>
Result<Value> in_flag(const char* flag, Result<Value> value) {
  if (!value.ok()) return Error{std::string(flag) + ": " + value.error().message};
  return value;
}

/// "512M", "1G", "64K" or bytes; powers of 1024.
Result<std::uint64_t> parse_bytes(const std::string& text);
/// "33ms", "1.5s"; a number alone is milliseconds.
Result<std::chrono::nanoseconds> parse_duration(const std::string& text);
/// "1280x720".
struct Size {
  std::uint32_t width = 0, height = 0;
};
std::optional<Size> parse_size(const std::string& text);
/// The numbers between commas, all finite; nothing where one is none.
std::optional<std::vector<double>> parse_list(const std::string& text);
/// "x,y,z".
Result<Vec3d> parse_vec3(const std::string& text);
/// "red,green,blue".
Result<Vec3d> parse_color(const std::string& text);

/// "1.3 GiB".
std::string bytes_text(std::uint64_t bytes);

}  // namespace gvx::app
