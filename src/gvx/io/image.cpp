#include "gvx/io/image.h"

#include <png.h>

#include "gvx/io/file_commit.h"
#include "gvx/io/file_source.h"
#include "gvx/io/header_text.h"

// libpng's simplified interface reports failures as values: no longjmp passes through C++ frames.

namespace gvx::io {
namespace {

constexpr std::uint64_t kMostPixels = std::uint64_t{1} << 28;

/// Frees what libpng keeps for a picture, on every way out.
struct PngImage {
  PngImage() { image.version = PNG_IMAGE_VERSION; }
  PngImage(const PngImage&) = delete;
  PngImage& operator=(const PngImage&) = delete;
  ~PngImage() { png_image_free(&image); }

  png_image image{};
};

Result<std::vector<std::byte>> read_whole_file(const std::string& path) {
  constexpr std::size_t kStep = std::size_t{1} << 20;
  GVX_ASSIGN(FileSource source, FileSource::open(path));
  std::vector<std::byte> bytes;
  for (std::size_t done = kStep; done == kStep;) {
    const std::size_t before = bytes.size();
    bytes.resize(before + kStep);
    GVX_ASSIGN(done, source.read(std::span(bytes).subspan(before)));
    bytes.resize(before + done);
  }
  return bytes;
}

}  // namespace

Status check_image_size(const std::string& path, std::uint32_t width, std::uint32_t height,
                        std::size_t samples) {
  const std::uint64_t pixels = std::uint64_t{width} * height;
  if (pixels < 1 || pixels > kMostPixels) {
    return file_error(path, "size: expected 1 to 2^28 pixels, found " + std::to_string(width) + " x " +
                                std::to_string(height));
  }
  if (samples != 4 * pixels) {
    return file_error(
        path, "samples: expected " + std::to_string(4 * pixels) + ", found " + std::to_string(samples));
  }
  return {};
}

Status write_png(const std::string& path, std::uint32_t width, std::uint32_t height,
                 std::span<const std::uint8_t> rgba) {
  GVX_TRY(check_image_size(path, width, height, rgba.size()));
  PngImage png;
  png.image.width = width;
  png.image.height = height;
  png.image.format = PNG_FORMAT_RGBA;
  // One pass into room for the worst case: asking for the exact size first would compress everything twice.
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(png.image);
  std::vector<std::byte> encoded(size);
  if (png_image_write_to_memory(&png.image, encoded.data(), &size, 0, rgba.data(), 0, nullptr) == 0) {
    return file_error(path, std::string("cannot encode PNG: ") + png.image.message);
  }
  return write_file_atomically(path, std::span(encoded).first(size));
}

Result<Image> read_png(const std::string& path) {
  GVX_ASSIGN(const std::vector<std::byte> encoded, read_whole_file(path));
  PngImage png;
  if (png_image_begin_read_from_memory(&png.image, encoded.data(), encoded.size()) == 0) {
    return file_error(path, std::string("cannot read PNG: ") + png.image.message);
  }
  Image image{png.image.width, png.image.height, {}};
  GVX_TRY(check_image_size(path, image.width, image.height, std::size_t{4} * image.width * image.height));
  png.image.format = PNG_FORMAT_RGBA;
  image.rgba.resize(std::size_t{4} * image.width * image.height);
  if (png_image_finish_read(&png.image, nullptr, image.rgba.data(), 0, nullptr) == 0) {
    return file_error(path, std::string("cannot read PNG: ") + png.image.message);
  }
  return image;
}

}  // namespace gvx::io
