#include "gvx/io/tiff_reader.h"

#include <algorithm>

#include "gvx/io/check_read.h"

namespace gvx::io {
namespace {

// Channels often lie in files of their own.
constexpr std::size_t kMostOpenFiles = 8;

}  // namespace

Result<std::unique_ptr<TiffReader>> TiffReader::open(TiffVolume volume) {
  GVX_TRY(check_description(volume.description));
  return std::unique_ptr<TiffReader>(new TiffReader(std::move(volume)));
}

Result<TiffFile*> TiffReader::open_file(std::uint32_t file) {
  const auto known =
      std::find_if(open_.begin(), open_.end(), [&](const OpenFile& o) { return o.index == file; });
  if (known != open_.end()) {
    std::rotate(known, known + 1, open_.end());
    return open_.back().file.get();
  }
  GVX_ASSIGN(auto opened, TiffFile::open(volume_.files[file]));
  if (open_.size() == kMostOpenFiles) open_.erase(open_.begin());
  open_.push_back({file, std::move(opened)});
  return open_.back().file.get();
}

Status TiffReader::read_slices(std::int64_t count, std::span<std::byte> out) {
  GVX_TRY(check_read(*this, count, out));
  const std::size_t bytes = slice_bytes(description());
  for (std::int64_t i = 0; i < count; ++i) {
    GVX_TRY(read_slice(next_slice_, out.subspan(static_cast<std::size_t>(i) * bytes, bytes)));
    ++next_slice_;
  }
  return {};
}

/// Samples that lie side by side in a page are read together.
Status TiffReader::read_slice(std::int64_t slice, std::span<std::byte> out) {
  const int components = description().components;
  const std::size_t bytes = sample_bytes(description().type);
  const TiffPlane* planes = volume_.planes.data() + slice * components;
  const bool any_missing =
      std::any_of(planes, planes + components, [](const TiffPlane& p) { return p.page < 0; });
  if (any_missing) std::fill(out.begin(), out.end(), std::byte{0});
  for (int c = 0, count = 1; c < components; c += count) {
    const auto follows = [&](int next) {
      return planes[next].page == planes[c].page && planes[next].sample == planes[c].sample + next - c;
    };
    for (count = 1; c + count < components && follows(c + count);) ++count;
    if (planes[c].page < 0) continue;
    const TiffPage& page = volume_.pages[static_cast<std::size_t>(planes[c].page)];
    GVX_ASSIGN(TiffFile * file, open_file(page.file));
    GVX_TRY(file->read(
        page, planes[c].sample, count,
        {out.data() + static_cast<std::size_t>(c) * bytes, static_cast<std::size_t>(components) * bytes}));
  }
  return {};
}

Status TiffReader::rewind() {
  next_slice_ = 0;
  return {};
}

}  // namespace gvx::io
