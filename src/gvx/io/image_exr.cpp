#include "gvx/io/header_text.h"
#include "gvx/io/image.h"

#ifdef GVX_WITH_OPENEXR

#include <algorithm>
#include <array>
#include <cstring>
#include <exception>

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfOutputFile.h>

#include "gvx/io/file_commit.h"

namespace gvx::io {
namespace {

/// Keeps what OpenEXR writes: it goes back to fill in its table of offsets, and the file must appear whole.
class MemoryStream final : public Imf::OStream {
 public:
  explicit MemoryStream(const std::string& path) : OStream(path.c_str()) {}

  void write(const char* bytes, int count) override {
    const auto size = static_cast<std::size_t>(count);
    written.resize(std::max(written.size(), position_ + size));
    std::memcpy(written.data() + position_, bytes, size);
    position_ += size;
  }
  std::uint64_t tellp() override { return position_; }
  void seekp(std::uint64_t position) override { position_ = static_cast<std::size_t>(position); }

  std::vector<std::byte> written;

 private:
  std::size_t position_ = 0;
};

void encode(std::uint32_t width, std::uint32_t height, std::span<const float> rgba, MemoryStream& stream) {
  constexpr std::array<const char*, 4> kChannels = {"R", "G", "B", "A"};
  Imf::Header header(static_cast<int>(width), static_cast<int>(height));
  header.compression() = Imf::ZIP_COMPRESSION;
  Imf::FrameBuffer pixels;
  for (std::size_t c = 0; c < kChannels.size(); ++c) {
    header.channels().insert(kChannels[c], Imf::Channel(Imf::FLOAT));
    // OpenEXR's slices are for reading too; an output file only reads through them.
    char* base = reinterpret_cast<char*>(const_cast<float*>(rgba.data() + c));
    pixels.insert(kChannels[c], Imf::Slice(Imf::FLOAT, base, 4 * sizeof(float), 4 * sizeof(float) * width));
  }
  Imf::OutputFile file(stream, header);
  file.setFrameBuffer(pixels);
  file.writePixels(static_cast<int>(height));
}

}  // namespace

Status write_exr(const std::string& path, std::uint32_t width, std::uint32_t height,
                 std::span<const float> rgba) {
  GVX_TRY(check_image_size(path, width, height, rgba.size()));
  MemoryStream stream(path);
  try {
    encode(width, height, rgba, stream);
  } catch (const std::exception& failure) {
    return file_error(path, std::string("cannot encode EXR: ") + failure.what());
  }
  return write_file_atomically(path, stream.written);
}

bool can_write_exr() {
  return true;
}

}  // namespace gvx::io

#else

namespace gvx::io {

Status write_exr(const std::string& path, std::uint32_t, std::uint32_t, std::span<const float>) {
  return file_error(path, "cannot write EXR: this gvx was built without OpenEXR");
}

bool can_write_exr() {
  return false;
}

}  // namespace gvx::io

#endif
