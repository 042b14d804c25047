/// \file
/// What the tests of volume formats share: small files, a volume with known samples, and reading it all back.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "gvx/io/volume_reader.h"

namespace gvx::io::test {

inline constexpr SampleType kAllSampleTypes[] = {
    SampleType::u8,  SampleType::i8,  SampleType::u16, SampleType::i16, SampleType::u32,
    SampleType::i32, SampleType::u64, SampleType::i64, SampleType::f32, SampleType::f64};

/// The shape of the volumes that the tests write: 4 * 3 * 2 samples.
inline constexpr Vec3i kSmallDimensions{4, 3, 2};

/// A name in a folder that belongs to this process and goes away with it: tests run side by side.
std::string temporary_path(const std::string& name);

inline void write_file(const std::string& path, std::string_view bytes) {
  std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

inline std::string read_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return std::string(std::istreambuf_iterator<char>(file), {});
}

/// The bytes of a number in either byte order.
template <typename T>
std::string bytes_of(T value, bool big_endian) {
  std::string bytes(sizeof value, '\0');
  std::memcpy(bytes.data(), &value, sizeof value);
  if (big_endian != (std::endian::native == std::endian::big))
    bytes = std::string(bytes.rbegin(), bytes.rend());
  return bytes;
}

/// Sample i of the small volume: different at every place, with both bytes of a 16-bit number in use,
/// negative ones where the type has them.
template <typename T>
T small_sample(int i) {
  if constexpr (sizeof(T) == 1) return static_cast<T>(i * 10);
  return static_cast<T>(i * 999 - (T(-1) < T(0) ? 12000 : 0));
}

/// The samples of the small volume as a file holds them.
inline std::string small_samples(SampleType type, bool big_endian) {
  return with_sample_type(type, [&](auto zero) {
    std::string bytes;
    for (int i = 0; i < 24; ++i) bytes += bytes_of(small_sample<decltype(zero)>(i), big_endian);
    return bytes;
  });
}

/// The samples of the small volume as a reader hands them out.
inline std::string native_small_samples(SampleType type) {
  return small_samples(type, std::endian::native == std::endian::big);
}

/// All slices, read `step` at a time.
inline Result<std::string> read_all(SliceReader& reader, std::int64_t step = 1) {
  const std::uint64_t slice = slice_bytes(reader.description());
  const std::int64_t depth = reader.description().dimensions.z;
  std::string samples;
  for (std::int64_t z = 0; z < depth; z += step) {
    const std::int64_t count = std::min(step, depth - z);
    const std::size_t before = samples.size();
    samples.resize(before + static_cast<std::size_t>(slice) * static_cast<std::size_t>(count));
    GVX_TRY(reader.read_slices(count, std::as_writable_bytes(std::span(samples).subspan(before))));
  }
  return samples;
}

/// Opens and reads a whole volume, or gives up with an error where it has more bytes than `limit`.
inline Result<std::string> load(const std::string& path, const VolumeOptions& options = {},
                                std::uint64_t limit = 1 << 26) {
  GVX_ASSIGN(const auto reader, open_volume(path, options));
  if (volume_bytes(reader->description()) > limit) return Error{path + ": larger than the test wants"};
  return read_all(*reader);
}

/// Opens a volume and returns its description.
inline Result<VolumeDescription> describe(const std::string& path, const VolumeOptions& options = {}) {
  GVX_ASSIGN(const auto reader, open_volume(path, options));
  return reader->description();
}

/// "ok", or the message of the error.
template <typename T>
std::string outcome(const Result<T>& result) {
  return result.ok() ? "ok" : result.error().message;
}

/// The folder that GVX_TEST_DATA names, ending in a slash; empty where it is unset or absent.
inline std::string data_folder() {
  const char* folder = std::getenv("GVX_TEST_DATA");
  return folder != nullptr && std::filesystem::is_directory(folder) ? std::string(folder) + "/"
                                                                    : std::string();
}

#define GVX_NEED_TEST_DATA(folder)          \
  const std::string folder = data_folder(); \
  if (folder.empty()) GTEST_SKIP() << "set GVX_TEST_DATA to the folder with third-party test data"

/// Packs bytes as gzip (windowBits 15+16) or zlib (15).
std::string deflated(std::string_view bytes, int window_bits);

/// Packs bytes as bzip2.
std::string bzipped(std::string_view bytes);

}  // namespace gvx::io::test
