#include "gvx/io/volume_reader.h"

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <utility>

#include "gvx/io/channel_merger.h"
#include "gvx/io/check_read.h"
#include "gvx/io/dicom.h"
#include "gvx/io/header_text.h"
#include "gvx/io/metaimage.h"
#include "gvx/io/nifti.h"
#include "gvx/io/nrrd.h"
#include "gvx/io/recognise.h"
#include "gvx/io/tiff.h"

namespace gvx::io {
namespace {

constexpr std::size_t kMostSurplus = std::size_t{1} << 20;
// A pipe may stay open behind the last sample for as long as its writer likes.
constexpr std::chrono::milliseconds kPatience{1000};

constexpr bool kNativeBigEndian = std::endian::native == std::endian::big;

std::uint16_t byte_swapped(std::uint16_t v) {
  return __builtin_bswap16(v);
}
std::uint32_t byte_swapped(std::uint32_t v) {
  return __builtin_bswap32(v);
}
std::uint64_t byte_swapped(std::uint64_t v) {
  return __builtin_bswap64(v);
}

template <typename Word>
void swap_words(std::span<std::byte> samples) {
  for (std::size_t at = 0; at < samples.size(); at += sizeof(Word)) {
    Word word;
    std::memcpy(&word, samples.data() + at, sizeof word);
    word = byte_swapped(word);
    std::memcpy(samples.data() + at, &word, sizeof word);
  }
}

void swap_samples(SampleType type, std::span<std::byte> samples) {
  switch (sample_bytes(type)) {
    case 2:
      return swap_words<std::uint16_t>(samples);
    case 4:
      return swap_words<std::uint32_t>(samples);
    case 8:
      return swap_words<std::uint64_t>(samples);
    default:
      return;
  }
}

Result<std::uint64_t> count_bytes_and_rewind(ByteStream& stream) {
  constexpr std::uint64_t kStep = std::uint64_t{1} << 30;
  std::uint64_t count = 0;
  for (;;) {
    GVX_ASSIGN(const std::uint64_t step, stream.skip(kStep));
    count += step;
    if (step < kStep) break;
  }
  GVX_TRY(stream.rewind());
  return count;
}

using Parser = Result<VolumeFile> (*)(const std::string& path, const VolumeOptions& options);

/// The parser of a format whose volumes do not change with time.
template <Result<VolumeFile> (*kParse)(const std::string&)>
Result<VolumeFile> parse_one_frame(const std::string& path, const VolumeOptions& options) {
  if (options.time) return file_error(path, "time: the volume does not change with time");
  return kParse(path);
}

Result<VolumeFile> parse_frame_of_nifti(const std::string& path, const VolumeOptions& options) {
  return parse_nifti(path, options.time);
}

Parser parser_for(FileKind kind) {
  switch (kind) {
    case FileKind::nrrd:
      return parse_one_frame<parse_nrrd>;
    case FileKind::nifti:
      return parse_frame_of_nifti;
    case FileKind::metaimage:
      return parse_one_frame<parse_metaimage>;
    default:
      return nullptr;
  }
}

/// For what is no volume.
Error no_volume(const std::string& path, const Recognised& found) {
  if (!found.problem.empty()) return not_read(path, found);
  switch (found.kind) {
    case FileKind::store:
      return file_error(path, "expected a volume file, found a gvx store");
    case FileKind::mesh:
      return file_error(
          path, "expected a volume, found a mesh; a mesh's name ends in .ply, .obj, .stl, .gltf or .glb");
    default:
      return file_error(path,
                        "not a file that gvx knows; expected a volume (NRRD, NIfTI, MetaImage, TIFF, DICOM), "
                        "or raw samples with "
                        "their shape (--dims X,Y,Z --dtype u8)");
  }
}

/// Of files that describe themselves.
Status check_no_raw_options(const std::string& path, const RawOptions& raw) {
  if (raw.dimensions || raw.type || raw.big_endian || raw.offset || raw.components) {
    return file_error(
        path, "describes itself: dimensions, type, components, byte order and offset are for raw files only");
  }
  if (raw.spacing) GVX_TRY(check_spacing(path, *raw.spacing));
  return {};
}

/// Not what the name says to be of another format, such as a slide, which is TIFF inside.
bool is_tiff_volume(const std::string& path) {
  if (path == "-") return false;
  const FileKind named = kind_by_name(path);
  return (named == FileKind::tiff || named == FileKind::unknown) && is_tiff(path);
}

Result<VolumeFile> describe_still_raw(const std::string& path, const VolumeOptions& options) {
  if (options.time) return file_error(path, "time: the volume does not change with time");
  return describe_raw(path, options.raw);
}

Result<VolumeFile> describe(const std::string& path, const VolumeOptions& options) {
  const RawOptions& raw = options.raw;
  if (path == "-") return describe_still_raw(path, options);
  std::error_code error;
  if (!std::filesystem::exists(path, error)) {
    return file_error(path, "cannot open: " + (error ? error.message() : "No such file or directory"));
  }
  const Recognised found = recognise(path);
  const FileKind named = kind_by_name(path);
  const bool names_raw = named == FileKind::raw || (raw.dimensions && parser_for(named) == nullptr);
  if (names_raw && !found.folder) {
    auto described = describe_still_raw(path, options);
    // Where nothing says the shape, the file may be something else.
    if (described.ok() || found.kind == FileKind::raw) return described;
  }
  const Parser parse = parser_for(found.kind);
  if (parse == nullptr) return no_volume(path, found);
  GVX_TRY(check_no_raw_options(path, raw));
  GVX_ASSIGN(VolumeFile file, parse(path, options));
  GVX_TRY(check_description(file.description));
  if (raw.spacing) {
    file.description.voxel_to_world = with_spacing(file.description.voxel_to_world, *raw.spacing);
  }
  return file;
}

/// A reader for each plane, whose samples it puts side by side.
Result<std::unique_ptr<SliceReader>> open_planes(const VolumeFile& file) {
  std::vector<std::unique_ptr<SliceReader>> planes;
  for (int i = 0; i < file.planes; ++i) {
    VolumeFile plane = file;
    const std::uint64_t before = static_cast<std::uint64_t>(i) * file.plane_bytes;
    plane.byte_skip += static_cast<std::int64_t>(before);
    plane.bytes_behind -= before;
    GVX_ASSIGN(planes.emplace_back(), VolumeReader::open(std::move(plane)));
  }
  GVX_ASSIGN(std::unique_ptr<SliceReader> merged, ChannelMerger::merge(std::move(planes)));
  return merged;
}

}  // namespace

Result<std::unique_ptr<VolumeReader>> VolumeReader::open(VolumeFile file) {
  GVX_TRY(check_description(file.description));
  if (file.data_paths.empty()) return file_error(file.description.path, "no data file is named");
  if (file.start.file_offset < 0 || file.start.line_skip < 0) {
    return file_error(file.description.path, "the data begin before their file");
  }
  std::unique_ptr<VolumeReader> reader(new VolumeReader(std::move(file)));
  GVX_TRY(reader->open_data_file(0));
  GVX_TRY(reader->check_other_files());
  return reader;
}

std::uint64_t VolumeReader::share_bytes() const {
  return volume_bytes(description()) / file_.data_paths.size();
}

/// Of a raw data file; lines that are skipped are not counted.
std::uint64_t VolumeReader::least_file_bytes() const {
  const std::int64_t before = file_.start.file_offset + std::max<std::int64_t>(file_.byte_skip, 0);
  return static_cast<std::uint64_t>(before) + share_bytes();
}

/// A file that lacks would otherwise be found when those before it have been read, hours later.
Status VolumeReader::check_other_files() const {
  for (std::size_t i = 1; i < file_.data_paths.size(); ++i) {
    const std::string& path = file_.data_paths[i];
    std::error_code error;
    const std::uintmax_t size = std::filesystem::file_size(path, error);
    if (error) {
      return file_error(description().path, "data file " + path + ": cannot open: " + error.message());
    }
    const std::uint64_t least = least_file_bytes();
    if (file_.encoding == Encoding::raw && size < least) {
      return file_error(path,
                        "size: expected " + std::to_string(least) + " bytes, found " + std::to_string(size));
    }
  }
  return {};
}

Status VolumeReader::open_data_file(std::size_t index) {
  const std::string& path = file_.data_paths[index];
  auto stream = open_byte_stream(path, file_.encoding, file_.start, description().type);
  if (!stream.ok()) {
    const bool detached = path != description().path;
    return detached ? file_error(description().path, "data file " + stream.error().message) : stream.error();
  }
  stream_ = std::move(stream).value();
  data_file_ = index;
  GVX_TRY(find_first_sample());
  GVX_TRY(check_size());
  return skip_to_first_sample();
}

Error VolumeReader::data_end_early(std::uint64_t bytes_there) const {
  return file_error(stream_->name(), "data end after " + std::to_string(bytes_there) + " of " +
                                         std::to_string(share_bytes()) + " bytes");
}

Status VolumeReader::find_first_sample() {
  if (file_.byte_skip != kSamplesAtEnd) {
    first_sample_ = static_cast<std::uint64_t>(file_.byte_skip);
    return {};
  }
  std::optional<std::uint64_t> there = stream_->bytes_left();
  if (!there) {
    GVX_ASSIGN(there, count_bytes_and_rewind(*stream_));
  }
  if (*there < share_bytes()) return data_end_early(*there);
  first_sample_ = *there - share_bytes();
  return {};
}

Status VolumeReader::check_size() const {
  const std::optional<std::uint64_t> there = stream_->bytes_left();
  if (!there) return {};
  const std::uint64_t expected = first_sample_ + share_bytes() + file_.bytes_behind;
  if (*there >= expected && !(file_.exact_size && *there > expected)) return {};
  return file_error(stream_->name(), "size: expected " + std::to_string(expected) + " bytes of data, found " +
                                         std::to_string(*there));
}

Status VolumeReader::skip_to_first_sample() {
  GVX_ASSIGN(const std::uint64_t skipped, stream_->skip(first_sample_));
  if (skipped < first_sample_) return data_end_early(0);
  share_left_ = share_bytes();
  return {};
}

Status VolumeReader::read_samples(std::span<std::byte> out) {
  const bool packed = file_.encoding == Encoding::gzip || file_.encoding == Encoding::bzip2;
  while (!out.empty()) {
    if (share_left_ == 0) GVX_TRY(open_data_file(data_file_ + 1));
    const auto part = out.first(static_cast<std::size_t>(std::min<std::uint64_t>(out.size(), share_left_)));
    GVX_ASSIGN(const std::size_t done, stream_->read(part));
    if (done < part.size()) return data_end_early(share_bytes() - share_left_ + done);
    share_left_ -= done;
    out = out.subspan(done);
    if (packed && share_left_ == 0) {
      // The checksum stands behind the last byte: without one more read it would go unchecked.
      behind_.resize(1);
      GVX_ASSIGN(const std::size_t more, stream_->read(behind_));
      behind_.resize(more);
    }
  }
  return {};
}

Status VolumeReader::read_slices(std::int64_t count, std::span<std::byte> out) {
  GVX_TRY(check_read(*this, count, out));
  GVX_TRY(read_samples(out));
  next_slice_ += count;
  const bool stored_big_endian =
      file_.encoding == Encoding::ascii ? kNativeBigEndian : description().big_endian;
  if (stored_big_endian != kNativeBigEndian) swap_samples(description().type, out);
  return {};
}

std::vector<Surplus> VolumeReader::surplus() {
  if (file_.encoding == Encoding::ascii || file_.byte_skip == kSamplesAtEnd) return {};
  if (file_.bytes_behind > 0) {
    // Of packed files no more than the frame is decoded.
    const auto skipped =
        stream_->bytes_left() ? stream_->skip(file_.bytes_behind) : Result<std::uint64_t>(std::uint64_t{0});
    if (!skipped.ok() || skipped.value() < file_.bytes_behind) return {};
  }
  const std::optional<std::uint64_t> left = stream_->bytes_left();
  const std::size_t known = behind_.size();
  bool counted = true;
  if (left || stream_->comes_within(kPatience)) {
    behind_.resize(
        known + static_cast<std::size_t>(std::min<std::uint64_t>(left.value_or(kMostSurplus), kMostSurplus)));
    const auto read = stream_->read(std::span(behind_).subspan(known));
    counted = read.ok() && known + read.value() < behind_.size();
    behind_.resize(known + (read.ok() ? read.value() : 0));
  }
  const bool line_end = behind_.size() <= 2 && std::all_of(behind_.begin(), behind_.end(), [](std::byte b) {
                          return b == std::byte{'\n'} || b == std::byte{'\r'};
                        });
  if (!line_end) return {{stream_->name(), left ? known + *left : behind_.size(), left || counted}};
  // Of the files before it one stands for all.
  for (std::size_t i = 0; i < data_file_ && file_.encoding == Encoding::raw; ++i) {
    std::error_code error;
    const std::uintmax_t size = std::filesystem::file_size(file_.data_paths[i], error);
    const bool larger = !error && file_.start.line_skip == 0 && size > least_file_bytes() + 2;
    if (larger) return {Surplus{file_.data_paths[i], size - least_file_bytes()}};
  }
  return {};
}

Status VolumeReader::rewind() {
  behind_.clear();
  next_slice_ = 0;
  if (data_file_ != 0) return open_data_file(0);
  GVX_TRY(stream_->rewind());
  return skip_to_first_sample();
}

Result<std::unique_ptr<SliceReader>> open_volume(const std::string& path, const VolumeOptions& options) {
  if (!options.raw.dimensions && is_dicom(path)) {
    GVX_TRY(check_no_raw_options(path, options.raw));
    return open_dicom(path, options);
  }
  if (is_tiff_volume(path)) {
    GVX_TRY(check_no_raw_options(path, options.raw));
    if (options.even_slices) return file_error(path, "even slices: only DICOM files have uneven ones");
    return open_tiff(path, options);
  }
  if (options.series) return file_error(path, "series: only DICOM folders and OME-TIFF files have several");
  if (options.even_slices) return file_error(path, "even slices: only DICOM files have uneven ones");
  GVX_ASSIGN(VolumeFile file, describe(path, options));
  if (file.planes > 1) return open_planes(file);
  GVX_ASSIGN(std::unique_ptr<SliceReader> reader, VolumeReader::open(std::move(file)));
  return reader;
}

std::vector<std::string> volume_files(const std::string& path, const VolumeOptions& options) {
  if (!options.raw.dimensions && is_dicom(path)) return dicom_files(path);
  if (is_tiff_volume(path)) return tiff_files(path, options);
  std::vector<std::string> files = {path};
  const auto described = describe(path, options);
  if (!described.ok()) return files;
  const auto add = [&](const std::string& file) {
    if (!file.empty() && file != path) files.push_back(file);
  };
  add(described.value().header_path);
  for (const std::string& file : described.value().data_paths) add(file);
  return files;
}

}  // namespace gvx::io
