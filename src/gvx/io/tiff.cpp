#include "gvx/io/tiff.h"

#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <system_error>

#include "gvx/io/header_text.h"
#include "gvx/io/tiff_names.h"

#ifdef GVX_WITH_TIFF
#include "gvx/io/tiff_reader.h"
#endif

namespace gvx::io {

bool is_tiff(const std::string& path) {
  std::error_code ignored;
  const auto status = std::filesystem::status(path, ignored);
  if (std::filesystem::is_directory(status)) {
    const auto names = tiff_names(path);
    return names.ok() && !names.value().empty();
  }
  if (is_tiff_name(path)) return std::filesystem::exists(status) || is_tiff_pattern(path);
  if (!std::filesystem::is_regular_file(status)) return false;
  std::array<char, 4> start{};
  std::ifstream(path, std::ios::binary).read(start.data(), start.size());
  for (const char* magic : {"II*\0", "MM\0*", "II+\0", "MM\0+"}) {
    if (std::memcmp(start.data(), magic, start.size()) == 0) return true;
  }
  return false;
}

#ifdef GVX_WITH_TIFF

Result<std::unique_ptr<SliceReader>> open_tiff(const std::string& path, const VolumeOptions& options) {
  GVX_ASSIGN(TiffVolume volume, find_tiff_volume(path, options));
  if (options.raw.spacing) {
    VolumeDescription& d = volume.description;
    d.voxel_to_world = with_spacing(d.voxel_to_world, *options.raw.spacing);
    d.unit.clear();
  }
  GVX_ASSIGN(std::unique_ptr<SliceReader> reader, TiffReader::open(std::move(volume)));
  return reader;
}

std::vector<std::string> tiff_files(const std::string& path, const VolumeOptions& options) {
  const auto volume = find_tiff_volume(path, options);
  std::vector<std::string> files = {path};
  if (!volume.ok()) return files;
  files.insert(files.end(), volume.value().files.begin(), volume.value().files.end());
  files.insert(files.end(), volume.value().others.begin(), volume.value().others.end());
  return files;
}

#else

Result<std::unique_ptr<SliceReader>> open_tiff(const std::string& path, const VolumeOptions&) {
  return file_error(
      path,
      "TIFF: this gvx was built without libtiff; install libtiff-dev and libexpat1-dev and build "
      "it again");
}

std::vector<std::string> tiff_files(const std::string& path, const VolumeOptions&) {
  return {path};
}

#endif

}  // namespace gvx::io
