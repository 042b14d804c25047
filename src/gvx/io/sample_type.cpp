#include "gvx/io/sample_type.h"

#include <array>
#include <string>

#include "gvx/io/header_text.h"

namespace gvx::io {
namespace {

struct Spelling {
  std::string_view name;
  SampleType type;
};

constexpr auto kSpellings = std::to_array<Spelling>({
    {"u8", SampleType::u8},
    {"uint8", SampleType::u8},
    {"uint8_t", SampleType::u8},
    {"uchar", SampleType::u8},
    {"unsigned char", SampleType::u8},
    {"i8", SampleType::i8},
    {"s8", SampleType::i8},
    {"int8", SampleType::i8},
    {"int8_t", SampleType::i8},
    {"char", SampleType::i8},
    {"signed char", SampleType::i8},
    {"u16", SampleType::u16},
    {"uint16", SampleType::u16},
    {"uint16_t", SampleType::u16},
    {"ushort", SampleType::u16},
    {"unsigned short", SampleType::u16},
    {"unsigned short int", SampleType::u16},
    {"i16", SampleType::i16},
    {"s16", SampleType::i16},
    {"int16", SampleType::i16},
    {"int16_t", SampleType::i16},
    {"short", SampleType::i16},
    {"short int", SampleType::i16},
    {"signed short", SampleType::i16},
    {"signed short int", SampleType::i16},
    {"u32", SampleType::u32},
    {"uint32", SampleType::u32},
    {"uint32_t", SampleType::u32},
    {"uint", SampleType::u32},
    {"unsigned int", SampleType::u32},
    {"i32", SampleType::i32},
    {"s32", SampleType::i32},
    {"int32", SampleType::i32},
    {"int32_t", SampleType::i32},
    {"int", SampleType::i32},
    {"signed int", SampleType::i32},
    {"u64", SampleType::u64},
    {"uint64", SampleType::u64},
    {"uint64_t", SampleType::u64},
    {"ulonglong", SampleType::u64},
    {"unsigned long long", SampleType::u64},
    {"unsigned long long int", SampleType::u64},
    {"i64", SampleType::i64},
    {"s64", SampleType::i64},
    {"int64", SampleType::i64},
    {"int64_t", SampleType::i64},
    {"longlong", SampleType::i64},
    {"long long", SampleType::i64},
    {"long long int", SampleType::i64},
    {"signed long long", SampleType::i64},
    {"signed long long int", SampleType::i64},
    {"f32", SampleType::f32},
    {"float32", SampleType::f32},
    {"float", SampleType::f32},
    {"f64", SampleType::f64},
    {"float64", SampleType::f64},
    {"double", SampleType::f64},
});

}  // namespace

std::size_t sample_bytes(SampleType type) {
  return with_sample_type(type, [](auto sample) { return sizeof(sample); });
}

const char* sample_name(SampleType type) {
  for (const Spelling& spelling : kSpellings) {
    if (spelling.type == type) return spelling.name.data();
  }
  return "?";
}

std::optional<SampleType> parse_sample_type(std::string_view name) {
  std::string normalized;
  for (const std::string_view word : words(name)) {
    if (!normalized.empty()) normalized += ' ';
    normalized += lower_case(word);
  }
  for (const Spelling& spelling : kSpellings) {
    if (spelling.name == normalized) return spelling.type;
  }
  return std::nullopt;
}

}  // namespace gvx::io
