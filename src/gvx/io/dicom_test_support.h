/// \file
/// A small writer of DICOM files for tests: explicit VR, little-endian unless told otherwise (PS3.5, section
/// 7).
#pragma once

#include <cstdint>
#include <cstdio>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "gvx/io/dicom_elements.h"
#include "gvx/io/volume_test_support.h"

namespace gvx::io::test {

/// Elements in the order of their tags, as a data set is written.
class DicomWriter {
 public:
  explicit DicomWriter(bool is_explicit = true, bool big_endian = false)
      : explicit_(is_explicit), big_endian_(big_endian) {}

  DicomWriter& text(DicomTag tag, const char* representation, std::string value) {
    if (value.size() % 2 != 0) value += ' ';
    return element(tag, representation, value);
  }
  DicomWriter& u16(DicomTag tag, std::vector<int> values) {
    std::string bytes;
    for (const int value : values) bytes += number(static_cast<std::uint16_t>(value));
    return element(tag, "US", bytes);
  }
  DicomWriter& u32(DicomTag tag, std::vector<std::uint32_t> values) {
    std::string bytes;
    for (const std::uint32_t value : values) bytes += number(value);
    return element(tag, "UL", bytes);
  }
  /// Items of unknown length, as most writers have them.
  DicomWriter& sequence(DicomTag tag, const std::vector<DicomWriter>& items) {
    std::string bytes;
    for (const DicomWriter& item : items) {
      bytes += tag_bytes(0xFFFEE000) + number(std::uint32_t{0xFFFFFFFF}) + item.bytes() +
               tag_bytes(0xFFFEE00D) + number(std::uint32_t{0});
    }
    bytes += tag_bytes(0xFFFEE0DD) + number(std::uint32_t{0});
    elements_[tag] = head(tag, "SQ", 0xFFFFFFFF) + bytes;
    return *this;
  }
  DicomWriter& element(DicomTag tag, const char* representation, const std::string& value) {
    elements_[tag] = head(tag, representation, static_cast<std::uint32_t>(value.size())) + value;
    return *this;
  }
  DicomWriter& without(DicomTag tag) {
    elements_.erase(tag);
    return *this;
  }
  /// Packed pixels, in fragments.
  DicomWriter& fragments(const std::vector<std::string>& all, const std::string& offsets = {}) {
    std::string bytes = tag_bytes(0xFFFEE000) + number(static_cast<std::uint32_t>(offsets.size())) + offsets;
    for (const std::string& one : all) {
      bytes += tag_bytes(0xFFFEE000) + number(static_cast<std::uint32_t>(one.size())) + one;
    }
    bytes += tag_bytes(0xFFFEE0DD) + number(std::uint32_t{0});
    elements_[kPixelData] = head(kPixelData, "OB", 0xFFFFFFFF) + bytes;
    return *this;
  }
  template <typename T>
  std::string number(T value) const {
    return bytes_of(value, big_endian_);
  }

  std::string bytes() const {
    std::string all;
    for (const auto& [tag, bytes] : elements_) all += bytes;
    return all;
  }

  /// The preamble and the file meta information before the data set.
  static std::string file(const std::string& transfer_syntax, const std::string& data_set) {
    DicomWriter meta;
    meta.text(0x00020010, "UI", transfer_syntax);
    std::string all(128, '\0');
    all += "DICM";
    all += meta.bytes();
    return all += data_set;
  }

 private:
  std::string tag_bytes(DicomTag tag) const {
    return number(static_cast<std::uint16_t>(tag >> 16)) + number(static_cast<std::uint16_t>(tag));
  }
  std::string head(DicomTag tag, std::string_view representation, std::uint32_t length) const {
    if (!explicit_) return tag_bytes(tag) + number(length);
    const bool is_long = representation == "OB" || representation == "OW" || representation == "SQ";
    return tag_bytes(tag) + std::string(representation) +
           (is_long ? std::string(2, '\0') + number(length) : number(static_cast<std::uint16_t>(length)));
  }

  bool explicit_, big_endian_;
  std::map<DicomTag, std::string> elements_;
};

inline constexpr const char* kImplicit = "1.2.840.10008.1.2";
inline constexpr const char* kExplicit = "1.2.840.10008.1.2.1";
inline constexpr const char* kDeflated = "1.2.840.10008.1.2.1.99";
inline constexpr const char* kBigEndian = "1.2.840.10008.1.2.2";
inline constexpr const char* kRunLengths = "1.2.840.10008.1.2.5";

/// "1\2\3"
inline std::string decimals(const std::vector<double>& numbers) {
  std::string text;
  for (const double number : numbers) {
    char one[32];
    std::snprintf(one, sizeof one, "%.10g", number);
    if (!text.empty()) text += '\\';
    text += one;
  }
  return text;
}

/// An axial slice of 4 x 3 pixels of 16 bits whose samples are 100 * instance + its index; rows 0.75 mm,
/// columns 0.5 mm apart.
inline DicomWriter dicom_slice(int instance, Vec3d position, DicomWriter slice = DicomWriter()) {
  slice.text(0x00080060, "CS", "CT").text(0x0020000E, "UI", "1.2.3").text(0x00200011, "IS", "7");
  slice.text(0x00200013, "IS", std::to_string(instance));
  slice.text(0x00200032, "DS", decimals({position.x, position.y, position.z}));
  slice.text(0x00200037, "DS", "1\\0\\0\\0\\1\\0").text(0x00280030, "DS", "0.75\\0.5");
  slice.u16(0x00280002, {1}).text(0x00280004, "CS", "MONOCHROME2").u16(0x00280010, {3}).u16(0x00280011, {4});
  slice.u16(0x00280100, {16}).u16(0x00280101, {16}).u16(0x00280102, {15}).u16(0x00280103, {1});
  std::string pixels;
  for (int i = 0; i < 12; ++i) pixels += slice.number(static_cast<std::int16_t>(100 * instance + i));
  return slice.element(kPixelData, "OW", pixels);
}

/// An empty folder.
inline std::string new_folder(const std::string& name) {
  const std::string path = temporary_path(name);
  std::filesystem::remove_all(path);
  std::filesystem::create_directories(path);
  return path;
}

inline void write_dicom(const std::string& path, const DicomWriter& data_set) {
  write_file(path, DicomWriter::file(kExplicit, data_set.bytes()));
}

/// A folder of slices at these places; instance numbers count from 1, and names sort the other way.
inline std::string folder_of_slices(const std::string& name, const std::vector<Vec3d>& places) {
  const std::string folder = new_folder(name);
  for (std::size_t i = 0; i < places.size(); ++i) {
    write_dicom(folder + "/" + static_cast<char>('z' - i) + ".dcm",
                dicom_slice(static_cast<int>(i) + 1, places[i]));
  }
  return folder;
}

/// The samples of a volume as numbers, after slope and intercept.
inline Result<std::vector<double>> values_of(const std::string& path, const VolumeOptions& options = {}) {
  GVX_ASSIGN(const auto reader, open_volume(path, options));
  GVX_ASSIGN(const std::string samples, read_all(*reader));
  const VolumeDescription& d = reader->description();
  std::vector<double> values;
  with_sample_type(d.type, [&](auto sample) {
    for (std::size_t at = 0; at < samples.size(); at += sizeof sample) {
      std::memcpy(&sample, samples.data() + at, sizeof sample);
      values.push_back(d.scale * static_cast<double>(sample) + d.offset);
    }
  });
  return values;
}

}  // namespace gvx::io::test
