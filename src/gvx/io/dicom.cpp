#include "gvx/io/dicom.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <optional>
#include <system_error>
#include <utility>

#include "gvx/io/dicom_reader.h"
#include "gvx/io/dicom_tags.h"
#include "gvx/io/header_text.h"

namespace gvx::io {
namespace {

namespace fs = std::filesystem;

constexpr int kDeepestFolder = 16;
constexpr std::size_t kMostFiles = std::size_t{1} << 18;
// To find out whether a folder holds a DICOM file at all.
constexpr std::size_t kMostLookedAt = 4096;
constexpr std::size_t kMostNamed = 6;

bool has_dicom_name(const std::string& path) {
  std::string name = lower_case(path);
  if (name.ends_with(".gz")) name.resize(name.size() - 3);
  return name.ends_with(".dcm") || name.ends_with(".dicom") || name.ends_with(".ima");
}

bool is_dicom_file(const std::string& path) {
  if (has_dicom_name(path)) return true;
  auto file = FileSource::open(path);
  if (!file.ok()) return false;
  std::array<std::byte, kDicomStartBytes> start;
  const auto size = file.value().read(start);
  return size.ok() && begins_as_dicom({reinterpret_cast<const char*>(start.data()), size.value()});
}

/// Things of one kind, and the first of them.
struct Counted {
  std::size_t count = 0;
  std::string first;

  void add(const std::string& one) {
    if (count++ == 0) first = one;
  }
};

/// Where a search of a folder did not look.
struct NotSearched {
  Counted closed_folders;  // with the reason
  Counted deep_folders;
  Counted folder_links;
  Counted dead_links;
  bool more_files = false;
};

/// Calls function(path) for the regular files of a folder and those in it until it returns true; is that so
/// for one? The order is that of the disk.
template <typename Function>
bool any_file(const std::string& top, NotSearched& missed, const Function& function) {
  std::vector<std::pair<fs::path, int>> left = {{top, 0}};
  std::size_t seen = 0;
  while (!left.empty()) {
    const auto [folder, depth] = left.back();
    left.pop_back();
    std::error_code error;
    for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
      std::error_code ignored;
      const std::string path = at->path().string();
      const bool is_link = at->is_symlink(ignored);
      const fs::file_type type = at->status(ignored).type();
      if (type == fs::file_type::directory) {
        if (is_link) {
          missed.folder_links.add(path);
        } else if (depth >= kDeepestFolder) {
          missed.deep_folders.add(path);
        } else {
          left.emplace_back(path, depth + 1);
        }
      } else if (type == fs::file_type::regular) {
        if (++seen > kMostFiles) {
          missed.more_files = true;
          return false;
        }
        if (function(path)) return true;
      } else if (is_link && (type == fs::file_type::not_found || type == fs::file_type::none)) {
        missed.dead_links.add(path);
      }
    }
    if (error) missed.closed_folders.add(folder.string() + ": " + error.message());
  }
  return false;
}

/// The files of a folder, sorted, or the one file.
std::vector<std::string> all_files(const std::string& path, NotSearched& missed) {
  std::error_code error;
  if (!fs::is_directory(path, error)) return {path};
  std::vector<std::string> files;
  any_file(path, missed, [&](std::string file) {
    files.push_back(std::move(file));
    return false;
  });
  std::sort(files.begin(), files.end());
  return files;
}

/// What was found in a folder beside images.
struct LeftOut {
  std::size_t others = 0;     // no DICOM files
  std::size_t no_images = 0;  // DICOM files without pixels
  std::size_t broken = 0;
  std::string first_broken;  // the error
  NotSearched not_searched;
};

Result<std::optional<DicomImage>> read_image(const std::string& path) {
  GVX_ASSIGN(DicomSource source, DicomSource::open(path));
  GVX_ASSIGN(const DicomHeader header, read_dicom_header(source));
  if (header.pixel_tag == 0) return std::optional<DicomImage>();
  GVX_ASSIGN(DicomImage image, interpret_dicom(header));
  return std::optional(std::move(image));
}

Result<std::vector<DicomImage>> read_images(const std::string& path, bool folder, LeftOut& left_out) {
  std::vector<DicomImage> images;
  for (const std::string& file : all_files(path, left_out.not_searched)) {
    if (folder && !is_dicom_file(file)) {
      ++left_out.others;
      continue;
    }
    auto image = read_image(file);
    // Of a folder the others count too: what is assumed is said in a remark.
    if (!folder && image.ok() && image.value() && !image.value()->unusable_value.empty())
      return file_error(path, image.value()->unusable_value);
    if (!image.ok()) {
      if (!folder) return image.error();
      if (left_out.broken++ == 0) left_out.first_broken = image.error().message;
    } else if (!image.value()) {
      if (!folder)
        return file_error(path, dicom_tag_name(kPixelData) + ": is absent: the file holds no image");
      ++left_out.no_images;
    } else {
      images.push_back(*std::move(image).value());
    }
  }
  if (!images.empty()) return images;
  if (left_out.broken > 0) return Error{left_out.first_broken};
  return file_error(path, "expected DICOM images, found " + std::to_string(left_out.no_images) +
                              " DICOM files without pixels and " + std::to_string(left_out.others) +
                              " other files");
}

std::string size_text(const DicomImage& image) {
  return std::to_string(image.slice_columns()) + " x " + std::to_string(image.slice_rows());
}

SeriesDescription describe_series(const std::vector<DicomImage>& images, const DicomSeries& series) {
  const DicomImage& image = images[series.slices.front().image];
  return {.number = series.label,
          .uid = image.series_uid,
          .description = image.description,
          .modality = image.modality,
          .dimensions = {image.slice_columns(), image.slice_rows(),
                         static_cast<std::int64_t>(series.stack.frames.front().size())},
          .frames = static_cast<std::int64_t>(series.stack.frames.size())};
}

std::size_t slices_of(const DicomSeries& series) {
  return series.stack.frames.front().size();
}

/// The others by their numbers, as --series takes them.
std::string names_of_others(const std::vector<DicomImage>& images, const std::vector<DicomSeries>& all,
                            const DicomSeries* chosen) {
  std::string text;
  std::size_t named = 0, more = 0;
  for (const DicomSeries& one : all) {
    if (&one == chosen) continue;
    if (named == kMostNamed) {
      ++more;
      continue;
    }
    ++named;
    const std::size_t slices = slices_of(one);
    text += (text.empty() ? "" : ", ") + io::quoted(one.label) + " (" + std::to_string(slices) +
            (slices == 1 ? " slice, " : " slices, ") + size_text(images[one.slices.front().image]) + ")";
  }
  return text + (more > 0 ? " and " + std::to_string(more) + " more" : "");
}

/// The series that is asked for, or the one with most slices.
Result<const DicomSeries*> choose_series(const std::string& path, const std::vector<DicomImage>& images,
                                         const std::vector<DicomSeries>& all,
                                         const std::optional<std::string>& asked,
                                         std::vector<std::string>& remarks) {
  const DicomSeries* chosen = nullptr;
  const DicomImage* image = nullptr;
  std::size_t fitting = 0, as_large = 0;
  for (const DicomSeries& one : all) {
    const DicomImage& first = images[one.slices.front().image];
    if (asked && *asked == one.label) {
      chosen = &one;
      fitting = 1;
      break;
    }
    if (asked && *asked != first.series_uid && *asked != first.series_number) continue;
    ++fitting;
    const auto size = [](const DicomSeries& s) { return std::pair(slices_of(s), s.stack.frames.size()); };
    if (chosen == nullptr || size(one) > size(*chosen)) {
      chosen = &one;
      as_large = 0;
    }
    as_large += slices_of(one) == slices_of(*chosen) ? 1 : 0;
  }
  if (chosen == nullptr) {
    return file_error(path, "series: expected one of " + names_of_others(images, all, nullptr) + ", found " +
                                io::quoted(*asked));
  }
  image = &images[chosen->slices.front().image];
  if (!asked && slices_of(*chosen) == 1 && chosen->stack.frames.size() == 1) {
    for (const DicomSeries& one : all) {
      const DicomImage& other = images[one.slices.front().image];
      if (&one == chosen || other.series_uid != image->series_uid || size_text(other) == size_text(*image))
        continue;
      return file_error(path, "the images of one series differ in size (" + size_text(*image) + " and " +
                                  size_text(other) + " pixels): --series chooses one of " +
                                  names_of_others(images, all, nullptr));
    }
  }
  if (fitting > 1) {
    remarks.push_back(
        "holds " + std::to_string(all.size()) + " series: " + io::quoted(chosen->label) +
        (as_large > 1 ? " is read, one of those with most slices (" : " is read, which has most slices (") +
        std::to_string(slices_of(*chosen)) +
        "); --series chooses another: " + names_of_others(images, all, chosen));
  }
  return chosen;
}

/// Do two slices hold the same pixels?
Result<bool> same_pixels(const std::vector<DicomImage>& images, DicomSlice a, DicomSlice b) {
  std::vector<std::byte> pixels[2];
  DicomPixels reader;
  for (int i = 0; const DicomSlice slice : {a, b}) {
    const DicomImage& image = images[slice.image];
    pixels[i].resize(
        static_cast<std::size_t>(image.slice_columns() * image.slice_rows() * image.format.components()) *
        sample_bytes(image.format.type()));
    GVX_TRY(reader.read_slice(image, image.frames[slice.frame], pixels[i++]));
  }
  return pixels[0] == pixels[1];
}

Status remark_on_duplicates(const std::vector<DicomImage>& images, const DicomStack& stack,
                            std::vector<std::string>& remarks) {
  if (stack.duplicates.empty()) return {};
  const auto [used, unused] = stack.duplicates.front();
  GVX_ASSIGN(const bool same, same_pixels(images, used, unused));
  const std::size_t count = stack.duplicates.size();
  const auto name = [&](DicomSlice slice) { return fs::path(images[slice.image].path).filename().string(); };
  remarks.push_back(std::to_string(count) + (count == 1 ? " slice lies" : " slices lie") +
                    " where another does and " + (count == 1 ? "is" : "are") + " not used" +
                    (count == 1 ? ": " : ", the first: ") + name(unused) + ", at the place of " + name(used) +
                    (same ? ", with the same pixels" : ", with other pixels: nothing says which is right"));
  return {};
}

void remark_on_frames(const DicomStack& stack, std::vector<std::string>& remarks) {
  if (stack.frames.size() > 1) {
    remarks.push_back("its " + std::to_string(stack.frames.size()) + " frames differ in " +
                      stack.frames_differ_in);
  }
  if (stack.incomplete_frames > 0) {
    remarks.push_back(std::to_string(stack.incomplete_frames) +
                      (stack.incomplete_frames == 1 ? " frame lacks" : " frames lack") + " slices and " +
                      (stack.incomplete_frames == 1 ? "is" : "are") + " left out");
  }
}

void remark_on_values(const DicomVolume& volume, std::vector<std::string>& remarks) {
  const DicomImage& image = volume.image(0);
  if (image.format.components() == 1 && !volume.one_scale()) {
    remarks.push_back(
        "slope and intercept differ from slice to slice: samples are rescaled to physical values");
  }
  if (image.format.color == DicomColor::inverted_gray)
    remarks.push_back("MONOCHROME1: low values are meant to be bright");
  if (image.has_value_table)
    remarks.push_back("its modality lookup table is not applied: values are as stored");
  if (image.format.components() == 3 && image.format.bits_stored > 8 &&
      image.format.color != DicomColor::palette) {
    remarks.push_back("colours of " + std::to_string(image.format.bits_stored) + " bits are reduced to 8");
  }
}

void remark_on_files(const LeftOut& left_out, std::vector<std::string>& remarks) {
  const auto files = [](std::size_t count, const char* one, const char* many) {
    return std::to_string(count) + (count == 1 ? one : many);
  };
  if (left_out.broken > 0) {
    remarks.push_back(files(left_out.broken, " DICOM file is", " DICOM files are") + " left out" +
                      (left_out.broken == 1 ? ": " : ", the first: ") + left_out.first_broken);
  }
  if (left_out.no_images > 0)
    remarks.push_back(files(left_out.no_images, " DICOM file holds", " DICOM files hold") + " no image");
  if (left_out.others > 0)
    remarks.push_back(files(left_out.others, " file is no DICOM file", " files are no DICOM files"));
}

void remark_on_folders(const NotSearched& missed, std::vector<std::string>& remarks) {
  const auto remark = [&](const Counted& counted, const char* one, const char* many) {
    if (counted.count == 0) return;
    remarks.push_back(std::to_string(counted.count) +
                      (counted.count == 1 ? one + std::string(": ") : many + std::string(", the first: ")) +
                      counted.first);
  };
  remark(missed.closed_folders, " folder cannot be read", " folders cannot be read");
  remark(missed.deep_folders, " folder is nested too deeply and not searched",
         " folders are nested too deeply and not searched");
  remark(missed.folder_links, " link to a folder is not followed", " links to folders are not followed");
  remark(missed.dead_links, " link leads nowhere", " links lead nowhere");
  if (missed.more_files)
    remarks.push_back("only the first " + std::to_string(kMostFiles) + " files are looked at");
}

/// Of the files of a volume: what is assumed of their values, and what is behind their pixels.
void remark_on_images(const DicomVolume& volume, std::vector<std::string>& remarks) {
  std::vector<std::size_t> used;
  for (const DicomSlice& slice : volume.slices) used.push_back(slice.image);
  std::sort(used.begin(), used.end());
  used.erase(std::unique(used.begin(), used.end()), used.end());
  Counted values, surplus;
  for (const std::size_t i : used) {
    const DicomImage& image = volume.images[i];
    if (!image.unusable_value.empty()) {
      values.add(image.path + ": " + image.unusable_value + "; " + image.assumed_value + " is assumed");
    }
    if (image.surplus_bytes > 0) {
      surplus.add(image.path + ": " + std::to_string(image.surplus_bytes) +
                  (image.surplus_bytes == 1 ? " byte is" : " bytes are") + " left over");
    }
  }
  const auto remark = [&](const Counted& counted, const std::string& what) {
    if (counted.count == 0) return;
    remarks.push_back(std::to_string(counted.count) + (counted.count == 1 ? " file has " : " files have ") +
                      what + (counted.count == 1 ? ": " : ", the first: ") + counted.first);
  };
  remark(values, "values whose scale is not usable");
  remark(surplus, "more pixel data than Rows x Columns needs");
}

}  // namespace

bool is_dicom(const std::string& path) {
  std::error_code error;
  if (fs::is_directory(path, error)) {
    bool found = false;
    std::size_t looked_at = 0;
    NotSearched ignored;
    any_file(path, ignored, [&](const std::string& file) {
      found = is_dicom_file(file);
      return found || ++looked_at == kMostLookedAt;
    });
    return found;
  }
  return fs::is_regular_file(path, error) && is_dicom_file(path);
}

std::vector<std::string> dicom_files(const std::string& path) {
  NotSearched ignored;
  std::vector<std::string> files = all_files(path, ignored);
  std::error_code error;
  if (fs::is_directory(path, error))
    std::erase_if(files, [](const std::string& f) { return !is_dicom_file(f); });
  return files;
}

Result<std::unique_ptr<SliceReader>> open_dicom(const std::string& path, const VolumeOptions& options) {
  std::error_code error;
  VolumeDescription description;
  description.path = path;
  while (description.path.size() > 1 && description.path.ends_with('/')) description.path.pop_back();
  LeftOut left_out;
  DicomVolume volume;
  GVX_ASSIGN(volume.images, read_images(description.path, fs::is_directory(path, error), left_out));
  GVX_ASSIGN(const std::vector<DicomSeries> series, group_dicom(volume.images));
  std::vector<std::string>& remarks = description.remarks;
  GVX_ASSIGN(const DicomSeries* const chosen,
             choose_series(description.path, volume.images, series, options.series, remarks));
  if (series.size() > 1) {
    for (const DicomSeries& one : series) description.series.push_back(describe_series(volume.images, one));
  }
  const DicomStack& stack = chosen->stack;
  description.frames = static_cast<std::int64_t>(stack.frames.size());
  description.frame = options.time.value_or(0);
  if (description.frame < 0 || description.frame >= description.frames) {
    return file_error(description.path, "time: expected a frame from 0 to " +
                                            std::to_string(description.frames - 1) + ", found " +
                                            std::to_string(description.frame));
  }
  volume.slices = stack.frames[static_cast<std::size_t>(description.frame)];
  remark_on_frames(stack, remarks);
  GVX_TRY(remark_on_duplicates(volume.images, stack, remarks));
  volume.geometry = place_slices(volume.images, volume.slices);
  if (options.raw.spacing) {
    if (options.even_slices)
      return file_error(description.path, "spacing: expected no --spacing with --even-slices");
    GVX_TRY(check_spacing(description.path, *options.raw.spacing));
    volume.geometry.voxel_to_world = with_spacing(volume.geometry.voxel_to_world, *options.raw.spacing);
  }
  const bool resample = options.even_slices && volume.geometry.anatomical && !volume.geometry.upright();
  if (!resample)
    remarks.insert(remarks.end(), volume.geometry.remarks.begin(), volume.geometry.remarks.end());
  remark_on_values(volume, remarks);
  remark_on_images(volume, remarks);
  remark_on_files(left_out, remarks);
  remark_on_folders(left_out.not_searched, remarks);
  std::unique_ptr<SliceReader> reader;
  if (resample) {
    GVX_ASSIGN(reader, EvenDicomReader::create(std::move(volume), std::move(description)));
  } else {
    reader = std::make_unique<DicomReader>(std::move(volume), std::move(description));
  }
  GVX_TRY(check_description(reader->description()));
  return reader;
}

}  // namespace gvx::io
