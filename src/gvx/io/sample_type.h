/// \file
/// SampleType: the number types that other people's volume files hold, and the names they give them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

namespace gvx::io {

/// What one stored sample is; complex numbers and colours are not among them.
enum class SampleType { u8, i8, u16, i16, u32, i32, u64, i64, f32, f64 };

/// For messages: the names of all sample types.
inline constexpr const char* kSampleTypeNames = "u8, i8, u16, i16, u32, i32, u64, i64, f32 or f64";

/// 1, 2, 4 or 8.
std::size_t sample_bytes(SampleType type);

/// The short name, such as "u16".
const char* sample_name(SampleType type);

/// Understands the short names and those of C, NumPy and NRRD in any case ("uint8", "unsigned char",
/// "float64").
std::optional<SampleType> parse_sample_type(std::string_view name);

/// Calls function(T{}) with the C++ type of the sample type.
template <typename Function>
decltype(auto) with_sample_type(SampleType type, Function&& function) {
  switch (type) {
    case SampleType::u8:
      return function(std::uint8_t{});
    case SampleType::i8:
      return function(std::int8_t{});
    case SampleType::u16:
      return function(std::uint16_t{});
    case SampleType::i16:
      return function(std::int16_t{});
    case SampleType::u32:
      return function(std::uint32_t{});
    case SampleType::i32:
      return function(std::int32_t{});
    case SampleType::u64:
      return function(std::uint64_t{});
    case SampleType::i64:
      return function(std::int64_t{});
    case SampleType::f32:
      return function(float{});
    case SampleType::f64:
      break;
  }
  return function(double{});
}

}  // namespace gvx::io
