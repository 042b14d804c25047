/// \file
/// DicomDataset: data elements of DICOM (PS3.5, section 7), by their tags.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace gvx::io {

/// Group and element number: 0xGGGGEEEE.
using DicomTag = std::uint32_t;

struct DicomElement;

/// Elements in the order of the file. Numbers are read by position in elements of several values.
class DicomDataset {
 public:
  /// The first of this tag, or null.
  const DicomElement* find(DicomTag tag) const;

  /// The value without the padding at its ends; empty where it is absent.
  std::string text(DicomTag tag) const;

  /// Every value of an element as a number, whether it is written as text or in binary; empty where it is
  /// absent, and NaN for a value that is no number.
  std::vector<double> numbers(DicomTag tag) const;

  /// The first value, if it is a finite number.
  std::optional<double> number(DicomTag tag) const;

  /// The first value where it is a whole number from 0 to 2^31-1.
  std::optional<std::int64_t> count(DicomTag tag) const;

  /// The items of a sequence; empty where it is absent.
  const std::vector<DicomDataset>& items(DicomTag tag) const;

  /// The first item of a sequence, or null.
  const DicomDataset* item(DicomTag tag) const;

  std::vector<DicomElement> elements;
};

struct DicomElement {
  DicomTag tag = 0;
  std::string value;                ///< Binary numbers in native byte order.
  std::vector<DicomDataset> items;  ///< Of a sequence.
};

/// "(0028,0010) Rows": what messages call an element.
std::string dicom_tag_name(DicomTag tag);

}  // namespace gvx::io
