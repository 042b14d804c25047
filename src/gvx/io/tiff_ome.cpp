// Which page of which file each plane of an OME-TIFF is (OME Data Model and File Formats, "OME-TIFF
// specification": the TiffData elements).

#include <algorithm>
#include <filesystem>
#include <map>
#include <system_error>

#include "gvx/io/header_text.h"
#include "gvx/io/ome_xml.h"
#include "gvx/io/tiff_volume.h"

namespace gvx::io {
namespace {

/// No more planes may be missing for each that is there.
constexpr std::int64_t kMostMissing = 64;

/// The files of a volume and their pages, each opened when its first plane is asked for.
class OmeFiles {
 public:
  OmeFiles(const std::string& path, std::string xml_path, const OmeMetadata& metadata,
           const std::vector<TiffPage>& pages)
      : path_(path), xml_path_(std::move(xml_path)), uuid_(metadata.uuid) {
    files.push_back(path);
    pages_.push_back(pages);
    index_of_[path] = 0;
  }

  /// The file of a block, or nothing where it is not there.
  Result<std::optional<std::size_t>> find(const OmeTiffData& data) {
    if (data.file_name.empty() || is_here(data)) return std::optional<std::size_t>(0);
    const std::string name = beside(xml_path_, data.file_name);
    if (const auto known = index_of_.find(name); known != index_of_.end()) return known->second;
    std::error_code failure;
    if (!std::filesystem::exists(name, failure)) {
      missing.push_back(data.file_name);
      index_of_[name] = std::nullopt;
      return std::optional<std::size_t>();
    }
    if (std::filesystem::equivalent(name, path_, failure)) return index_of_[name] = 0;
    GVX_ASSIGN(const auto file, TiffFile::open(name));
    GVX_ASSIGN(auto pages, file->pages());
    for (TiffPage& page : pages) page.file = static_cast<std::uint32_t>(files.size());
    index_of_[name] = files.size();
    files.push_back(name);
    pages_.push_back(std::move(pages));
    return index_of_[name];
  }

  /// Does the block name pages of the file that was asked for, as far as names tell?
  bool in_first(const OmeTiffData& data) const {
    return data.file_name.empty() || is_here(data) ||
           std::filesystem::path(data.file_name).filename() == std::filesystem::path(path_).filename();
  }

  const std::vector<TiffPage>& pages(std::size_t file) const { return pages_[file]; }
  std::int64_t page_count() const {
    std::int64_t count = 0;
    for (const auto& pages : pages_) count += static_cast<std::int64_t>(pages.size());
    return count;
  }

  std::vector<std::string> files, missing;

 private:
  bool is_here(const OmeTiffData& data) const {
    return xml_path_ == path_ && !data.uuid.empty() && data.uuid == uuid_;
  }

  std::string path_, xml_path_, uuid_;
  std::vector<std::vector<TiffPage>> pages_;
  std::map<std::string, std::optional<std::size_t>> index_of_;
};

/// Of the image at one time: fewer than SizeC where the XML counts a page's samples as channels, such as the
/// 3 of an RGB page.
std::int64_t pages_a_slice(const OmeImage& image, const std::vector<TiffPage>& pages) {
  const std::int64_t together = pages.front().samples;
  return together > 1 && image.c % together == 0 ? image.c / together : image.c;
}

/// Counts planes in the order in which pages follow each other.
struct PlaneOrder {
  std::int64_t sizes[3];    ///< Fastest first.
  int z = 0, c = 0, t = 0;  ///< Which of them is which.

  PlaneOrder(const OmeImage& image, std::int64_t channels) {
    for (int i = 0; i < 3; ++i) {
      const char axis = image.order[static_cast<std::size_t>(i) + 2];
      (axis == 'Z' ? z : axis == 'C' ? c : t) = i;
      sizes[i] = axis == 'Z' ? image.z : axis == 'C' ? channels : image.t;
    }
  }
  std::int64_t all() const {
    std::int64_t product = 0;
    if (__builtin_mul_overflow(sizes[0], sizes[1], &product) ||
        __builtin_mul_overflow(product, sizes[2], &product)) {
      return INT64_MAX;
    }
    return product;
  }
  std::int64_t place(int axis, std::int64_t plane) const {
    if (axis > 0) plane /= sizes[0];
    if (axis > 1) plane /= sizes[1];
    return plane % sizes[axis];
  }
  bool beyond(const OmeTiffData& data) const {
    return data.z >= sizes[z] || data.c >= sizes[c] || data.t >= sizes[t];
  }
  std::int64_t plane(const OmeTiffData& data) const {
    std::int64_t places[3];
    places[z] = data.z, places[c] = data.c, places[t] = data.t;
    return places[0] + sizes[0] * (places[1] + sizes[1] * places[2]);
  }
};

/// The pages of the planes of one frame, by slice and channel.
class PlaneFinder {
 public:
  PlaneFinder(OmeFiles& files, const PlaneOrder& order, std::int64_t frame)
      : files_(files), order_(order), frame_(frame) {}

  Status add(const std::string& path, const OmeTiffData& data) {
    if (order_.beyond(data)) {
      return file_error(path, "TiffData: FirstZ, FirstC or FirstT lies beyond the size of the axis");
    }
    const std::int64_t begin = order_.plane(data);
    // Most blocks are single planes: of those of other frames no file is opened.
    if (data.pages == 1 && order_.place(order_.t, begin) != frame_) return {};
    GVX_ASSIGN(const auto file, files_.find(data));
    if (!file) return {};
    const auto there = static_cast<std::int64_t>(files_.pages(*file).size());
    const std::int64_t count =
        std::min({data.pages.value_or(INT64_MAX), there - data.page, order_.all() - begin});
    steps_ += std::max<std::int64_t>(count, 0);
    if (steps_ > 16 * files_.page_count()) return file_error(path, "TiffData: names pages again and again");
    for (std::int64_t i = 0; i < count; ++i) {
      if (order_.place(order_.t, begin + i) != frame_) continue;
      const std::pair key(order_.place(order_.z, begin + i), order_.place(order_.c, begin + i));
      found_.emplace(key, std::pair(*file, data.page + i));
    }
    return {};
  }

  using Found = std::map<std::pair<std::int64_t, std::int64_t>, std::pair<std::size_t, std::int64_t>>;
  const Found& found() const { return found_; }

 private:
  OmeFiles& files_;
  const PlaneOrder& order_;
  std::int64_t frame_;
  std::int64_t steps_ = 0;
  Found found_;
};

/// A remark on pages of full size in the file itself that are no plane of any image, or nothing.
std::string pages_without_planes(const OmeFiles& files, const OmeMetadata& metadata) {
  const std::vector<TiffPage>& pages = files.pages(0);
  const auto there = static_cast<std::int64_t>(pages.size());
  std::vector<bool> named(pages.size());
  std::int64_t steps = 0;
  const std::vector<OmeTiffData> everything(1);
  for (const OmeImage& image : metadata.images) {
    const PlaneOrder order(image, pages_a_slice(image, pages));
    for (const OmeTiffData& data : image.data.empty() ? everything : image.data) {
      if (!files.in_first(data) || order.beyond(data)) continue;
      const std::int64_t left = order.all() == INT64_MAX ? INT64_MAX : order.all() - order.plane(data);
      const std::int64_t count = std::min({data.pages.value_or(INT64_MAX), there - data.page, left});
      steps += std::max<std::int64_t>(count, 0);
      if (steps > 16 * there) return {};
      for (std::int64_t i = 0; i < count; ++i) named[static_cast<std::size_t>(data.page + i)] = true;
    }
  }
  std::int64_t count = 0, first = 0;
  for (std::size_t i = 0; i < pages.size(); ++i) {
    if (named[i] || pages[i].reduced || is_smaller_copy(pages[i], pages.front())) continue;
    if (count++ == 0) first = pages[i].number;
  }
  if (count == 0) return {};
  const std::string page = "page " + std::to_string(first);
  return "OME-XML does not say which planes " +
         (count == 1 ? page + " is; it is not read"
                     : page + " and " + std::to_string(count - 1) +
                           (count == 2 ? " other are" : " others are") + "; they are not read");
}

Result<const OmeImage*> choose_image(const OmeMetadata& metadata, const VolumeOptions& options,
                                     VolumeDescription& d) {
  const std::vector<OmeImage>& images = metadata.images;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < images.size(); ++i) {
    const OmeImage& image = images[i];
    names.push_back(std::to_string(i + 1) + " (" + (image.name.empty() ? "" : io::quoted(image.name) + ", ") +
                    std::to_string(image.x) + " x " + std::to_string(image.y) + " x " +
                    std::to_string(image.z) + ")");
  }
  if (images.empty()) return file_error(d.path, "OME-XML: expected an Image with Pixels, found none");
  if (!options.series) {
    if (images.size() > 1) {
      d.remarks.push_back("has " + std::to_string(images.size()) + " images: " + some_of(names) +
                          "; the first is read (--series NUMBER chooses another)");
    }
    return &images.front();
  }
  const auto number = parse_integer(*options.series);
  if (!number || *number < 1 || *number > static_cast<std::int64_t>(images.size())) {
    return file_error(d.path, "series: expected a number from 1 to " + std::to_string(images.size()) + ": " +
                                  some_of(names) + ", found " + io::quoted(*options.series));
  }
  return &images[static_cast<std::size_t>(*number) - 1];
}

/// In the file's unit where its axes agree, else in micrometres.
void set_ome_place(const OmeImage& image, VolumeDescription& d) {
  std::array<std::optional<double>, 3> spacing = image.spacing;
  std::optional<std::string> unit;
  bool alike = true, lengths = true;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!spacing[axis]) continue;
    if (unit && *unit != image.unit[axis]) alike = false;
    unit = image.unit[axis];
    lengths = lengths && micrometres_of(image.unit[axis]).has_value();
  }
  if (unit) d.unit = unit->empty() ? "\xC2\xB5m" : *unit;
  if (!alike && lengths) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (spacing[axis]) *spacing[axis] *= *micrometres_of(image.unit[axis]);
    }
    d.unit = "\xC2\xB5m";
  } else if (!alike) {
    d.unit.clear();
    d.remarks.push_back("the units of its axes cannot be compared; the numbers are read as they are");
  }
  set_place(spacing, d);
}

void set_channels(const OmeImage& image, int samples, VolumeDescription& d) {
  if (d.colors || image.channels.empty()) return;
  std::vector<ChannelDescription> channels(static_cast<std::size_t>(d.components));
  bool white = true;
  for (std::size_t c = 0; c < channels.size(); ++c) {
    const std::size_t from = c / static_cast<std::size_t>(samples);
    if (from >= image.channels.size()) return;
    channels[c] = {image.channels[from].name, image.channels[from].color};
    const auto color = channels[c].color;
    white = white && color && color->x == 1 && color->y == 1 && color->z == 1;
  }
  // The schema's default: nobody chose it.
  if (white && channels.size() > 1) {
    for (ChannelDescription& channel : channels) channel.color.reset();
  }
  const bool says_something = std::any_of(channels.begin(), channels.end(), [](const ChannelDescription& c) {
    return !c.name.empty() || c.color;
  });
  if (says_something && samples == 1) d.channels = channels;
}

}  // namespace

Result<TiffVolume> find_ome_volume(const std::string& path, const std::string& xml_path,
                                   const std::string& xml, const TiffFile& file,
                                   const std::vector<TiffPage>& pages, const VolumeOptions& options) {
  GVX_ASSIGN(const OmeMetadata metadata, parse_ome_xml(xml_path, xml));
  TiffVolume volume;
  VolumeDescription& d = volume.description;
  d.path = path;
  GVX_ASSIGN(const OmeImage* image, choose_image(metadata, options, d));
  if (!options.raw.spacing) d.remarks.insert(d.remarks.end(), image->remarks.begin(), image->remarks.end());
  GVX_ASSIGN(const std::int64_t frame, choose_frame(options, image->t, d));

  const std::int64_t channels = pages_a_slice(*image, pages);
  const PlaneOrder order(*image, channels);
  if (order.all() == INT64_MAX) return file_error(path, "OME-XML: expected less than 2^63 planes");
  OmeFiles files(path, xml_path, metadata, pages);
  PlaneFinder finder(files, order, frame);
  const std::vector<OmeTiffData> everything(1);
  for (const OmeTiffData& data : image->data.empty() ? everything : image->data) {
    GVX_TRY(finder.add(path, data));
  }
  const auto& found = finder.found();
  if (found.empty()) {
    return file_error(path,
                      files.missing.empty()
                          ? "OME-XML: no page of the file is a plane of this image and frame"
                          : "OME-XML: its planes are in files that are not there: " + some_of(files.missing));
  }
  const auto there = static_cast<std::int64_t>(found.size());
  const std::int64_t planes = image->z * channels;
  if (planes / kMostMissing > there) {
    return file_error(path, "OME-XML: SizeZ and SizeC: expected " + std::to_string(planes) +
                                " planes, found " + std::to_string(there));
  }

  std::map<std::pair<std::int64_t, std::int64_t>, std::int64_t> page_of;
  for (const auto& [plane, place] : found) {
    const TiffPage& page = files.pages(place.first)[static_cast<std::size_t>(place.second)];
    if (page.width != image->x || page.height != image->y ||
        (!volume.pages.empty() && !same_shape(page, volume.pages.front()))) {
      return file_error(files.files[place.first],
                        "page " + std::to_string(page.number) + ": expected " +
                            (volume.pages.empty() ? std::to_string(image->x) + " x " +
                                                        std::to_string(image->y) + " pixels, as OME-XML says"
                                                  : shape_text(volume.pages.front()) + ", as other planes") +
                            ", found " + shape_text(page));
    }
    page_of[plane] = static_cast<std::int64_t>(volume.pages.size());
    volume.pages.push_back(page);
  }
  GVX_ASSIGN(const int samples, describe_samples(file, volume.pages.front(), image->z, channels, d));
  set_planes(volume, samples, [&](std::int64_t slice, std::int64_t channel) {
    const auto page = page_of.find({slice, channel});
    return page == page_of.end() ? -1 : page->second;
  });
  if (there < planes) {
    d.remarks.push_back(
        std::to_string(planes - there) + " of " + std::to_string(planes) +
        " planes are missing and read as 0" +
        (files.missing.empty() ? "" : "; these files are not there: " + some_of(files.missing)));
  }
  if (const std::string remark = pages_without_planes(files, metadata); !remark.empty())
    d.remarks.push_back(remark);
  set_ome_place(*image, d);
  set_channels(*image, samples, d);
  volume.files = files.files;
  if (xml_path != path) volume.others.push_back(xml_path);
  return volume;
}

}  // namespace gvx::io
