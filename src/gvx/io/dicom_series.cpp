#include "gvx/io/dicom_series.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>

#include "gvx/io/header_text.h"

namespace gvx::io {
namespace {

constexpr std::size_t kMostSeries = 1024;
// Directions are written with about six digits, positions with hundredths of a millimetre or better.
constexpr double kSameDirection = 2e-3;
constexpr double kSamePlace = 0.01;

const DicomFrame& frame_of(const std::vector<DicomImage>& images, DicomSlice slice) {
  return images[slice.image].frames[slice.frame];
}

bool same_direction(Vec3d a, Vec3d b) {
  return length(a - b) < kSameDirection;
}

bool same_spacing(double a, double b) {
  return a == b || std::abs(a - b) <= 0.01 * std::max(a, b);
}

bool belong_together(const DicomImage& a, const DicomFrame& fa, const DicomImage& b, const DicomFrame& fb) {
  return a.series_uid == b.series_uid && a.format == b.format && a.tiles == b.tiles && a.placed == b.placed &&
         same_direction(fa.row, fb.row) && same_direction(fa.column, fb.column) &&
         same_spacing(fa.row_spacing, fb.row_spacing) && same_spacing(fa.column_spacing, fb.column_spacing);
}

/// Slices that may lie at one place, by their place along the normal.
struct Placed {
  DicomSlice slice;
  double along = 0;
  std::size_t place = 0;
};

/// Sorts by place; those within kSamePlace of each other share one. Returns the number of places.
std::size_t sort_by_place(std::vector<Placed>& all) {
  std::stable_sort(all.begin(), all.end(),
                   [](const Placed& a, const Placed& b) { return a.along < b.along; });
  std::size_t places = 0;
  double begun = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (i == 0 || all[i].along - begun > kSamePlace) {
      ++places;
      begun = all[i].along;
    }
    all[i].place = places - 1;
  }
  return places;
}

/// Sorts the slices of one series into frames of time.
class Stacker {
 public:
  Stacker(const std::vector<DicomImage>& images, std::vector<Placed> slices)
      : images_(images), all_(std::move(slices)) {
    // The order of equals: a file seen first by its instance number.
    std::stable_sort(all_.begin(), all_.end(),
                     [&](const Placed& a, const Placed& b) { return order(a) < order(b); });
    places_ = sort_by_place(all_);
    count_.resize(places_);
    for (const Placed& placed : all_) ++count_[placed.place];
  }

  DicomStack stack() {
    DicomStack stack;
    const auto shared = static_cast<std::size_t>(
        std::count_if(count_.begin(), count_.end(), [](std::size_t n) { return n > 1; }));
    if (shared == 0) {
      stack.frames.push_back(slices_of(all_));
      return stack;
    }
    // A slice or two that were taken again are no points in time.
    if (2 * shared >= places_) {
      if (split_by_keys(stack)) return stack;
      if (std::all_of(count_.begin(), count_.end(), [&](std::size_t n) { return n == count_.front(); })) {
        split_by_order(stack);
        return stack;
      }
    }
    leave_out_duplicates(stack);
    return stack;
  }

 private:
  std::tuple<std::int64_t, const std::string&, std::int64_t> order(const Placed& placed) const {
    const DicomImage& image = images_[placed.slice.image];
    return {image.instance, image.path, image.frames[placed.slice.frame].number};
  }

  static std::vector<DicomSlice> slices_of(const std::vector<Placed>& placed) {
    std::vector<DicomSlice> slices;
    for (const Placed& one : placed) slices.push_back(one.slice);
    return slices;
  }

  double key_of(const Placed& placed, DicomKey key) const {
    const double value = frame_of(images_, placed.slice).keys[static_cast<std::size_t>(key)];
    return std::isnan(value) ? -std::numeric_limits<double>::infinity() : value;
  }

  int compare(const Placed& a, const Placed& b, const std::vector<DicomKey>& keys) const {
    for (const DicomKey key : keys) {
      const double of_a = key_of(a, key), of_b = key_of(b, key);
      if (of_a != of_b) return of_a < of_b ? -1 : 1;
    }
    return 0;
  }

  /// How well some keys sort the slices into stacks.
  struct Split {
    std::size_t duplicates = 0;  // slices with the same keys and place
    std::size_t largest = 0;     // places of the largest stack
  };

  Split try_keys(const std::vector<DicomKey>& keys) {
    std::stable_sort(all_.begin(), all_.end(), [&](const Placed& a, const Placed& b) {
      const int order = compare(a, b, keys);
      return order != 0 ? order < 0 : a.place < b.place;
    });
    Split split;
    std::size_t in_stack = 0;
    for (std::size_t i = 0; i < all_.size(); ++i) {
      const bool same_stack = i > 0 && compare(all_[i - 1], all_[i], keys) == 0;
      const bool duplicate = same_stack && all_[i - 1].place == all_[i].place;
      split.duplicates += duplicate ? 1 : 0;
      in_stack = duplicate ? in_stack : same_stack ? in_stack + 1 : 1;
      split.largest = std::max(split.largest, in_stack);
    }
    return split;
  }

  bool split_by_keys(DicomStack& stack) {
    std::vector<DicomKey> keys;
    std::size_t duplicates = all_.size() - places_;
    for (int k = 0; k < kDicomKeys && duplicates > 0; ++k) {
      std::vector<DicomKey> more = keys;
      more.push_back(static_cast<DicomKey>(k));
      const Split split = try_keys(more);
      // A key that is different for each slice says nothing of points in time.
      if (split.duplicates >= duplicates || 2 * split.largest < places_) continue;
      keys = std::move(more);
      duplicates = split.duplicates;
    }
    if (duplicates > 0) {
      try_keys({});
      return false;
    }
    const std::size_t largest = try_keys(keys).largest;
    for (std::size_t begin = 0, end = 0; begin < all_.size(); begin = end) {
      end = begin + 1;
      while (end < all_.size() && compare(all_[begin], all_[end], keys) == 0) ++end;
      if (end - begin < largest) {
        ++stack.incomplete_frames;
      } else {
        stack.frames.push_back(slices_of({all_.begin() + static_cast<std::ptrdiff_t>(begin),
                                          all_.begin() + static_cast<std::ptrdiff_t>(end)}));
      }
    }
    for (const DicomKey key : keys) {
      stack.frames_differ_in +=
          (stack.frames_differ_in.empty() ? "" : " and ") + std::string(dicom_key_name(key));
    }
    return true;
  }

  /// As many slices at each place, told apart by nothing but their order.
  void split_by_order(DicomStack& stack) {
    const std::size_t frames = count_.front();
    std::stable_sort(all_.begin(), all_.end(), [&](const Placed& a, const Placed& b) {
      return a.place != b.place ? a.place < b.place : order(a) < order(b);
    });
    stack.frames.resize(frames);
    for (std::size_t i = 0; i < all_.size(); ++i) stack.frames[i % frames].push_back(all_[i].slice);
    stack.frames_differ_in = "instance number";
  }

  void leave_out_duplicates(DicomStack& stack) {
    std::stable_sort(all_.begin(), all_.end(), [&](const Placed& a, const Placed& b) {
      return a.place != b.place ? a.place < b.place : order(a) < order(b);
    });
    std::vector<DicomSlice> used;
    for (std::size_t i = 0; i < all_.size(); ++i) {
      if (i > 0 && all_[i - 1].place == all_[i].place) {
        stack.duplicates.emplace_back(used.back(), all_[i].slice);
      } else {
        used.push_back(all_[i].slice);
      }
    }
    stack.frames.push_back(std::move(used));
  }

  const std::vector<DicomImage>& images_;
  std::vector<Placed> all_;
  std::size_t places_ = 0;
  std::vector<std::size_t> count_;  // of slices, by place
};

/// Lays images that do not say where they lie one behind the other.
void lay_in_order(std::vector<DicomImage>& images, const std::vector<DicomSlice>& slices) {
  std::vector<std::size_t> order;
  for (const DicomSlice& slice : slices) order.push_back(slice.image);
  const auto location = [&](std::size_t i) { return images[i].slice_location; };
  std::vector<double> locations;
  for (const std::size_t i : order) locations.push_back(location(i));
  std::sort(locations.begin(), locations.end());
  const bool located =
      std::none_of(locations.begin(), locations.end(), [](double l) { return std::isnan(l); }) &&
      std::adjacent_find(locations.begin(), locations.end()) == locations.end();
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    if (located) return location(a) < location(b);
    return std::tie(images[a].instance, images[a].path) < std::tie(images[b].instance, images[b].path);
  });
  double step = images[order.front()].slice_step;
  if (step <= 0) step = images[order.front()].frames.front().column_spacing;
  if (step <= 0) step = 1;
  for (std::size_t k = 0; k < order.size(); ++k) {
    DicomFrame& frame = images[order[k]].frames.front();
    frame.position = static_cast<double>(k) * step * normalize(cross(frame.row, frame.column));
  }
}

std::string number_of(const DicomImage& image) {
  return image.series_number.empty() ? "none" : image.series_number;
}

/// In the order of their numbers; those that share one get .1, .2 ..
void label(const std::vector<DicomImage>& images, std::vector<DicomSeries>& series) {
  const auto image = [&](const DicomSeries& s) -> const DicomImage& {
    return images[s.slices.front().image];
  };
  std::stable_sort(series.begin(), series.end(), [&](const DicomSeries& a, const DicomSeries& b) {
    const auto of_a = parse_number(image(a).series_number), of_b = parse_number(image(b).series_number);
    if (of_a.has_value() != of_b.has_value()) return of_a.has_value();
    if (of_a && *of_a != *of_b) return *of_a < *of_b;
    return std::tie(image(a).series_number, image(a).series_uid) <
           std::tie(image(b).series_number, image(b).series_uid);
  });
  std::map<std::string, int> shared, given;
  for (const DicomSeries& one : series) ++shared[number_of(image(one))];
  for (DicomSeries& one : series) {
    const std::string number = number_of(image(one));
    one.label = shared[number] == 1 ? number : number + "." + std::to_string(++given[number]);
  }
}

}  // namespace

Result<std::vector<DicomSeries>> group_dicom(std::vector<DicomImage>& images) {
  std::vector<DicomSeries> series;
  std::map<std::string, std::vector<std::size_t>> by_uid;
  for (std::size_t i = 0; i < images.size(); ++i) {
    std::vector<std::size_t>& candidates = by_uid[images[i].series_uid];
    for (std::size_t f = 0; f < images[i].frames.size(); ++f) {
      const auto found = std::find_if(candidates.begin(), candidates.end(), [&](std::size_t s) {
        const DicomSlice first = series[s].slices.front();
        return belong_together(images[first.image], frame_of(images, first), images[i], images[i].frames[f]);
      });
      if (found != candidates.end()) {
        series[*found].slices.push_back({i, f});
        continue;
      }
      if (series.size() == kMostSeries)
        return file_error(images[i].path, "expected at most 1024 series of one orientation each");
      candidates.push_back(series.size());
      series.push_back({.label = {}, .slices = {{i, f}}, .stack = {}});
    }
  }
  label(images, series);
  for (DicomSeries& one : series) {
    const DicomImage& first = images[one.slices.front().image];
    if (!first.placed && !first.stacked) lay_in_order(images, one.slices);
    const DicomFrame& frame = frame_of(images, one.slices.front());
    const Vec3d normal = normalize(cross(frame.row, frame.column));
    std::vector<Placed> placed;
    for (const DicomSlice& slice : one.slices)
      placed.push_back({slice, dot(normal, frame_of(images, slice).position), 0});
    one.stack = Stacker(images, std::move(placed)).stack();
  }
  return series;
}

}  // namespace gvx::io
