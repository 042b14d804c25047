#include "gvx/io/tiff_volume.h"

#include <algorithm>
#include <filesystem>
#include <system_error>

#include "gvx/io/header_text.h"
#include "gvx/io/ome_xml.h"
#include "gvx/io/tiff_imagej.h"
#include "gvx/io/tiff_names.h"

namespace gvx::io {
namespace {

std::string counted(std::int64_t count, const char* one, const char* many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

Error other_shape(const TiffFile& file, const TiffPage& page, const TiffPage& expected,
                  const std::string& whose) {
  return file.error(page,
                    "expected " + shape_text(expected) + " as " + whose + ", found " + shape_text(page));
}

/// The pages that are no levels of others; an error where they are not of one shape.
Result<std::vector<TiffPage>> slices_of(const TiffFile& file, const std::vector<TiffPage>& pages,
                                        VolumeDescription& d) {
  const auto full = std::find_if(pages.begin(), pages.end(), [](const TiffPage& p) { return !p.reduced; });
  if (full == pages.end()) return file_error(file.path(), "expected pages of full size, found copies only");
  std::vector<TiffPage> slices;
  for (const TiffPage& page : pages) {
    if (page.reduced || is_smaller_copy(page, *full)) continue;
    if (!same_shape(page, *full)) {
      return other_shape(file, page, *full, "page " + std::to_string(full->number) + " has");
    }
    slices.push_back(page);
  }
  const auto levels = static_cast<std::int64_t>(pages.size() - slices.size());
  if (levels > 0) {
    d.remarks.push_back(counted(levels, "page is a smaller copy", "pages are smaller copies") +
                        " or masks of others; they are not read");
  }
  return slices;
}

/// A large stack of ImageJ: one directory, and the samples of all pages one after the other.
Status add_raw_pages(const TiffFile& file, const ImageJInfo& info, std::vector<TiffPage>& pages) {
  const TiffPage first = pages.front();
  const std::uint64_t bytes = static_cast<std::uint64_t>(first.width) *
                              static_cast<std::uint64_t>(first.height) *
                              static_cast<std::uint64_t>(first.samples * first.bits / 8);
  if (bytes == 0 || first.raw_position > file.size_bytes()) {
    return file.error(first, "expected samples within the file");
  }
  const std::uint64_t there = (file.size_bytes() - first.raw_position) / bytes;
  if (there < static_cast<std::uint64_t>(info.images)) {
    return file_error(file.path(), "ImageJ's description: expected " + std::to_string(info.images) +
                                       " images, found the samples of " + std::to_string(there) +
                                       ": the file is cut short");
  }
  for (std::int64_t i = 1; i < info.images; ++i) {
    TiffPage page = first;
    page.number = i + 1;
    page.raw = true;
    page.raw_position += static_cast<std::uint64_t>(i) * bytes;
    pages.push_back(page);
  }
  return {};
}

void set_imagej_place(const ImageJInfo& info, VolumeDescription& d) {
  set_place(info.spacing, d);
  const Vec3d origin = d.voxel_to_world.vector(info.origin);
  d.voxel_to_world.origin = d.voxel_to_world.origin - origin;
  d.unit = info.unit;
  d.scale = info.scale;
  d.offset = info.offset;
  if (d.components > 1 && !d.colors && info.colors.size() >= static_cast<std::size_t>(d.components)) {
    d.channels.resize(static_cast<std::size_t>(d.components));
    for (std::size_t c = 0; c < d.channels.size(); ++c) d.channels[c].color = info.colors[c];
  }
}

Result<TiffVolume> imagej_volume(const std::string& path, const TiffFile& file, std::vector<TiffPage> pages,
                                 const ImageJInfo& info, const VolumeOptions& options) {
  TiffVolume volume;
  volume.description.path = path;
  volume.files = {path};
  const TiffPage& first = pages.front();
  const bool whole_bytes = first.bits % 8 == 0 && first.bits != 24;
  if (pages.size() == 1 && info.images > 1 && first.raw_position != 0 && whole_bytes &&
      first.unreadable.empty() && !first.reduced) {
    GVX_TRY(add_raw_pages(file, info, pages));
  }
  GVX_ASSIGN(volume.pages, slices_of(file, pages, volume.description));
  const auto count = static_cast<std::int64_t>(volume.pages.size());
  std::int64_t channels = info.channels, slices = info.slices, frames = info.frames;
  // Of a stack that was changed by another program the description may be an old one.
  if (channels > count || slices > count || frames > count || channels * slices > count ||
      channels * slices * frames != count) {
    if (info.images > 1 || count > 1) {
      volume.description.remarks.push_back(
          (info.images != count
               ? "ImageJ's description speaks of " + std::to_string(info.images) +
                     " images, but the file has " + std::to_string(count)
               : "ImageJ's description: channels x slices x frames is " + std::to_string(channels) + " x " +
                     std::to_string(slices) + " x " + std::to_string(frames) +
                     ", which is not the number of images, " + std::to_string(count)) +
          "; its pages are read as slices");
    }
    channels = frames = 1;
    slices = count;
  }
  GVX_ASSIGN(const std::int64_t frame, choose_frame(options, frames, volume.description));
  GVX_ASSIGN(const int samples,
             describe_samples(file, volume.pages.front(), slices, channels, volume.description));
  set_planes(volume, samples, [&](std::int64_t slice, std::int64_t channel) {
    return channel + channels * (slice + slices * frame);
  });
  set_imagej_place(info, volume.description);
  return volume;
}

Result<TiffVolume> stack_volume(const std::string& path, const TiffFile& file,
                                const std::vector<TiffPage>& pages, const VolumeOptions& options) {
  TiffVolume volume;
  volume.description.path = path;
  volume.files = {path};
  GVX_ASSIGN(volume.pages, slices_of(file, pages, volume.description));
  GVX_ASSIGN(const std::int64_t frame, choose_frame(options, 1, volume.description));
  (void)frame;
  GVX_ASSIGN(const int samples,
             describe_samples(file, volume.pages.front(), static_cast<std::int64_t>(volume.pages.size()), 1,
                              volume.description));
  set_planes(volume, samples, [](std::int64_t slice, std::int64_t) { return slice; });
  set_place({}, volume.description);
  return volume;
}

/// Says which pages a file may have beside its own, where it only names the file with the metadata.
Result<TiffVolume> binary_only_volume(const std::string& path, const OmeMetadata& metadata,
                                      const TiffFile& file, const std::vector<TiffPage>& pages,
                                      const VolumeOptions& options) {
  constexpr std::uintmax_t kMostXmlBytes = std::uintmax_t{1} << 30;
  const std::string companion = beside(path, metadata.metadata_file);
  std::error_code failure;
  const std::uintmax_t bytes = std::filesystem::file_size(companion, failure);
  if (failure) {
    GVX_ASSIGN(TiffVolume volume, stack_volume(path, file, pages, options));
    volume.description.remarks.push_back(
        "its OME metadata are in " + metadata.metadata_file +
        ", which is not there: spacing, channels and other files are not known; a pattern with * in its "
        "name reads several files as slices");
    return volume;
  }
  if (bytes > kMostXmlBytes) return file_error(companion, "OME-XML: expected at most 1 GiB");
  GVX_ASSIGN(FileSource source, FileSource::open(companion));
  std::string xml(static_cast<std::size_t>(bytes), '\0');
  GVX_ASSIGN(const std::size_t read, source.read(std::as_writable_bytes(std::span(xml))));
  xml.resize(read);
  return find_ome_volume(path, companion, xml, file, pages, options);
}

Result<TiffVolume> file_volume(const std::string& path, const VolumeOptions& options) {
  GVX_ASSIGN(const auto file, TiffFile::open(path));
  GVX_ASSIGN(const std::vector<TiffPage> pages, file->pages());
  const std::string& text = file->tags().description;
  if (is_ome_xml(text)) {
    GVX_ASSIGN(const OmeMetadata metadata, parse_ome_xml(path, text));
    if (metadata.images.empty() && !metadata.metadata_file.empty())
      return binary_only_volume(path, metadata, *file, pages, options);
    return find_ome_volume(path, path, text, *file, pages, options);
  }
  if (options.series) return file_error(path, "series: only DICOM folders and OME-TIFF files have several");
  if (const auto info = parse_imagej(file->tags())) return imagej_volume(path, *file, pages, *info, options);
  return stack_volume(path, *file, pages, options);
}

/// The one page of a file that is a slice.
Result<TiffPage> slice_of_file(const TiffFile& file, const std::string& whole, TiffVolume& volume,
                               const std::vector<TiffPage>& pages) {
  VolumeDescription ignored;
  GVX_ASSIGN(const std::vector<TiffPage> slices, slices_of(file, pages, ignored));
  if (slices.size() != 1) {
    return file_error(whole, "expected files of one slice each, but " + file.path() + " has " +
                                 std::to_string(slices.size()) +
                                 " pages; give one file, or up to four of one shape as channels");
  }
  if (!volume.pages.empty() && !same_shape(slices.front(), volume.pages.front())) {
    return other_shape(file, slices.front(), volume.pages.front(), volume.files.front() + " has");
  }
  return slices.front();
}

Result<TiffVolume> files_volume(const std::string& path, const std::vector<std::string>& names,
                                const VolumeOptions& options) {
  if (names.size() == 1) return file_volume(names.front(), options);
  TiffVolume volume;
  volume.description.path = path;
  std::optional<ImageJInfo> imagej;
  std::optional<VolumeDescription> ome;  // of the first slice
  std::unique_ptr<TiffFile> first;
  for (const std::string& name : names) {
    GVX_ASSIGN(auto file, TiffFile::open(name));
    GVX_ASSIGN(const std::vector<TiffPage> pages, file->pages());
    if (volume.files.empty() && is_ome_xml(file->tags().description)) {
      GVX_ASSIGN(TiffVolume named, file_volume(name, options));
      if (named.files.size() > 1) {
        named.description.path = path;
        return named;
      }
      ome = named.description;
    }
    GVX_ASSIGN(TiffPage slice, slice_of_file(*file, path, volume, pages));
    slice.file = static_cast<std::uint32_t>(volume.files.size());
    volume.pages.push_back(slice);
    volume.files.push_back(name);
    if (first == nullptr) {
      imagej = parse_imagej(file->tags());
      first = std::move(file);
    }
  }
  if (options.series) return file_error(path, "series: only DICOM folders and OME-TIFF files have several");
  GVX_ASSIGN(const std::int64_t frame, choose_frame(options, 1, volume.description));
  (void)frame;
  GVX_ASSIGN(const int samples,
             describe_samples(*first, volume.pages.front(), static_cast<std::int64_t>(names.size()), 1,
                              volume.description));
  set_planes(volume, samples, [](std::int64_t slice, std::int64_t) { return slice; });
  if (const std::string gaps = gaps_in_numbers(names); !gaps.empty())
    volume.description.remarks.push_back(gaps);
  if (ome) {
    for (const std::string& remark : ome->remarks) {
      if (remark.starts_with("OME-XML: PhysicalSize")) volume.description.remarks.push_back(remark);
    }
    volume.description.voxel_to_world = ome->voxel_to_world;
    volume.description.unit = ome->unit;
  } else if (imagej) {
    set_imagej_place(*imagej, volume.description);
  } else {
    set_place({}, volume.description);
  }
  return volume;
}

/// Names without a file behind them.
std::string no_slices(const std::vector<std::string>& names) {
  const std::size_t others = names.size() - 1;
  return names.front() +
         (others == 0   ? ""
          : others == 1 ? " and 1 other"
                        : " and " + std::to_string(others) + " others") +
         " (a folder, a pipe, a device or a link to nothing, not a file)";
}

}  // namespace

Result<TiffVolume> find_tiff_volume(const std::string& path, const VolumeOptions& options) {
  std::error_code ignored;
  if (!std::filesystem::is_directory(path, ignored) && !is_tiff_pattern(path))
    return file_volume(path, options);
  std::vector<std::string> no_files;
  GVX_ASSIGN(const std::vector<std::string> names, tiff_names(path, &no_files));
  if (names.empty()) {
    return file_error(path, "expected TIFF files (.tif, .tiff), found none" +
                                (no_files.empty() ? std::string() : " but " + no_slices(no_files)));
  }
  GVX_ASSIGN(TiffVolume volume, files_volume(path, names, options));
  if (!no_files.empty()) volume.description.remarks.push_back("left out: " + no_slices(no_files));
  return volume;
}

Result<std::int64_t> choose_frame(const VolumeOptions& options, std::int64_t frames, VolumeDescription& d) {
  d.frames = frames;
  d.frame = options.time.value_or(0);
  if (d.frame < 0 || d.frame >= frames) {
    return file_error(d.path, frames == 1 ? "time: the volume does not change with time"
                                          : "time: expected a frame from 0 to " + std::to_string(frames - 1) +
                                                ", found " + std::to_string(d.frame));
  }
  if (frames > 1 && !options.time) {
    d.remarks.push_back("has " + std::to_string(frames) + " frames in time; the first is read (--time 0 to " +
                        std::to_string(frames - 1) + " chooses one)");
  }
  return d.frame;
}

Result<int> describe_samples(const TiffFile& file, const TiffPage& page, std::int64_t slices,
                             std::int64_t channels, VolumeDescription& d) {
  if (!page.unreadable.empty()) return file.error(page, page.unreadable);
  d.dimensions = {page.width, page.height, slices};
  d.type = page.type;
  const bool rgb = page.colors == TiffColors::rgb;
  d.colors = rgb && channels == 1 && page.type == SampleType::u8 && page.bits == 8;
  int samples = page.alpha_sample > 0 ? page.alpha_sample : page.samples;
  if (rgb) samples = d.colors && page.alpha_sample == 3 ? 4 : 3;
  const std::int64_t all = channels * samples;
  d.components = static_cast<int>(std::min<std::int64_t>(all, 4));
  if (all > 4) {
    d.remarks.push_back("has " + std::to_string(all) +
                        " channels; the first 4 are read (a volume has at most 4)");
  }
  if (page.samples > samples) {
    d.remarks.push_back(page.alpha_sample == samples ? "its opacity (alpha) is not read"
                                                     : "samples behind the colours are not read");
  }
  if (rgb && !d.colors && channels == 1) {
    d.channels = {{"red", Vec3f{1, 0, 0}}, {"green", Vec3f{0, 1, 0}}, {"blue", Vec3f{0, 0, 1}}};
  }
  if (page.colors == TiffColors::palette)
    d.remarks.push_back("has a palette; its numbers are read, not its colours");
  if (page.colors == TiffColors::min_is_white)
    d.remarks.push_back("0 is white in this file (MinIsWhite); its numbers are read as they are");
  if (page.orientation != 1) {
    d.remarks.push_back("orientation " + std::to_string(page.orientation) +
                        " is not applied: rows and columns are as stored");
  }
  return samples;
}

void set_planes(TiffVolume& volume, int samples,
                const std::function<std::int64_t(std::int64_t slice, std::int64_t channel)>& page_of) {
  const VolumeDescription& d = volume.description;
  volume.planes.reserve(static_cast<std::size_t>(d.dimensions.z * d.components));
  for (std::int64_t z = 0; z < d.dimensions.z; ++z) {
    for (int c = 0; c < d.components; ++c) volume.planes.push_back({page_of(z, c / samples), c % samples});
  }
}

void set_place(const std::array<std::optional<double>, 3>& spacing, VolumeDescription& d) {
  d.voxel_to_world =
      from_index_to_centre(scaling({spacing[0].value_or(1), spacing[1].value_or(1), spacing[2].value_or(1)}));
}

std::string some_of(const std::vector<std::string>& names) {
  constexpr std::size_t kShown = 3;
  std::string text;
  for (std::size_t i = 0; i < std::min(kShown, names.size()); ++i) text += (i > 0 ? ", " : "") + names[i];
  if (names.size() > kShown)
    text += " and " + counted(static_cast<std::int64_t>(names.size() - kShown), "other", "others");
  return text;
}

}  // namespace gvx::io
