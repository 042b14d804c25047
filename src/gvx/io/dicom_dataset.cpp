#include "gvx/io/dicom_dataset.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <limits>
#include <string_view>

#include "gvx/io/dicom_tags.h"
#include "gvx/io/header_text.h"

namespace gvx::io {

const DicomElement* DicomDataset::find(DicomTag tag) const {
  const auto at = std::find_if(elements.begin(), elements.end(),
                               [tag](const DicomElement& element) { return element.tag == tag; });
  return at != elements.end() ? &*at : nullptr;
}

std::string DicomDataset::text(DicomTag tag) const {
  const DicomElement* const element = find(tag);
  if (element == nullptr) return {};
  const std::string_view value = std::string_view(element->value).substr(0, element->value.find('\0'));
  return std::string(trimmed(value));
}

std::vector<double> DicomDataset::numbers(DicomTag tag) const {
  const DicomElement* const element = find(tag);
  const DicomTagEntry* const entry = find_dicom_tag(tag);
  std::vector<double> all;
  if (element == nullptr || entry == nullptr) return all;
  const auto add = [&](auto zero) {
    for (std::size_t at = 0; at + sizeof zero <= element->value.size(); at += sizeof zero) {
      std::memcpy(&zero, element->value.data() + at, sizeof zero);
      all.push_back(static_cast<double>(zero));
    }
  };
  switch (entry->value) {
    case DicomValue::u16:
    case DicomValue::tag:
      add(std::uint16_t{});
      return all;
    case DicomValue::u32:
      add(std::uint32_t{});
      return all;
    case DicomValue::f32:
      add(float{});
      return all;
    case DicomValue::f64:
      add(double{});
      return all;
    default:
      break;
  }
  const std::string whole = text(tag);
  std::string_view rest = whole;
  while (!whole.empty()) {
    const std::size_t bar = rest.find('\\');
    std::string_view word = trimmed(rest.substr(0, bar));
    if (word.starts_with('+')) word.remove_prefix(1);
    all.push_back(parse_number(word).value_or(std::numeric_limits<double>::quiet_NaN()));
    if (bar == std::string_view::npos) break;
    rest.remove_prefix(bar + 1);
  }
  return all;
}

std::optional<double> DicomDataset::number(DicomTag tag) const {
  const std::vector<double> all = numbers(tag);
  if (all.empty() || !std::isfinite(all.front())) return std::nullopt;
  return all.front();
}

std::optional<std::int64_t> DicomDataset::count(DicomTag tag) const {
  const std::optional<double> value = number(tag);
  if (!value || *value < 0 || *value > 2147483647.0 || *value != std::floor(*value)) return std::nullopt;
  return static_cast<std::int64_t>(*value);
}

const std::vector<DicomDataset>& DicomDataset::items(DicomTag tag) const {
  static const std::vector<DicomDataset> none;
  const DicomElement* const element = find(tag);
  return element != nullptr ? element->items : none;
}

const DicomDataset* DicomDataset::item(DicomTag tag) const {
  const std::vector<DicomDataset>& all = items(tag);
  return all.empty() ? nullptr : &all.front();
}

std::string dicom_tag_name(DicomTag tag) {
  std::array<char, 16> number;
  std::snprintf(number.data(), number.size(), "(%04X,%04X)", tag >> 16, tag & 0xFFFF);
  const DicomTagEntry* const entry = find_dicom_tag(tag);
  return number.data() + (entry != nullptr ? std::string(" ") + entry->name : std::string());
}

}  // namespace gvx::io
