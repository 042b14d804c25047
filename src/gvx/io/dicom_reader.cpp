#include "gvx/io/dicom_reader.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "gvx/io/check_read.h"
#include "gvx/io/header_text.h"

namespace gvx::io {
namespace {

constexpr double kLongestAxis = 65536;

/// value = slope * sample + intercept, for all samples of a slice.
template <typename Value>
void rescale(SampleType type, std::span<const std::byte> samples, const DicomFrame& frame, Value* out) {
  with_sample_type(type, [&](auto sample) {
    for (std::size_t at = 0; at < samples.size(); at += sizeof sample) {
      std::memcpy(&sample, samples.data() + at, sizeof sample);
      *out++ = static_cast<Value>(frame.slope * static_cast<double>(sample) + frame.intercept);
    }
  });
}

void describe_pixels(const DicomVolume& volume, VolumeDescription& description) {
  const DicomPixelFormat& format = volume.image(0).format;
  description.dimensions = {volume.image(0).slice_columns(), volume.image(0).slice_rows(),
                            static_cast<std::int64_t>(volume.slices.size())};
  description.type = format.type();
  description.components = format.components();
  description.colors = format.components() == 3;
  description.voxel_to_world = volume.geometry.voxel_to_world;
  description.anatomical = volume.geometry.anatomical;
}

std::uint64_t stored_slice_bytes(const DicomImage& image) {
  return static_cast<std::uint64_t>(image.slice_columns() * image.slice_rows() * image.format.components()) *
         sample_bytes(image.format.type());
}

/// What most steps are at least: some slices that lie closer together shall not multiply the others.
double even_step(const DicomGeometry& geometry) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < geometry.places.size(); ++i)
    steps.push_back(geometry.places[i].z - geometry.places[i - 1].z);
  if (steps.empty()) return geometry.spacing.z;
  const auto low = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 10);
  std::nth_element(steps.begin(), low, steps.end());
  return *low;
}

}  // namespace

bool DicomVolume::one_scale() const {
  for (std::size_t i = 1; i < slices.size(); ++i) {
    if (frame(i).slope != frame(0).slope || frame(i).intercept != frame(0).intercept) return false;
  }
  return true;
}

DicomReader::DicomReader(DicomVolume volume, VolumeDescription description)
    : volume_(std::move(volume)), description_(std::move(description)) {
  describe_pixels(volume_, description_);
  if (description_.colors) return;
  rescaled_ = !volume_.one_scale();
  if (rescaled_) {
    description_.type = sample_bytes(description_.type) < 4 || description_.type == SampleType::f32
                            ? SampleType::f32
                            : SampleType::f64;
  } else {
    description_.scale = volume_.frame(0).slope;
    description_.offset = volume_.frame(0).intercept;
  }
}

Status DicomReader::read_slices(std::int64_t count, std::span<std::byte> out) {
  const std::size_t slice_size = slice_bytes(description_);
  GVX_TRY(check_read(*this, count, out));
  for (std::int64_t i = 0; i < count; ++i, ++next_slice_) {
    const auto slice = static_cast<std::size_t>(next_slice_);
    const DicomImage& image = volume_.image(slice);
    const auto to = out.subspan(static_cast<std::size_t>(i) * slice_size, slice_size);
    if (!rescaled_) {
      GVX_TRY(pixels_.read_slice(image, volume_.frame(slice), to));
      continue;
    }
    stored_.resize(stored_slice_bytes(image));
    GVX_TRY(pixels_.read_slice(image, volume_.frame(slice), stored_));
    if (description_.type == SampleType::f32) {
      rescale(image.format.type(), stored_, volume_.frame(slice), reinterpret_cast<float*>(to.data()));
    } else {
      rescale(image.format.type(), stored_, volume_.frame(slice), reinterpret_cast<double*>(to.data()));
    }
  }
  return {};
}

Status DicomReader::rewind() {
  next_slice_ = 0;
  return {};
}

Result<std::unique_ptr<SliceReader>> EvenDicomReader::create(DicomVolume volume,
                                                             VolumeDescription description) {
  describe_pixels(volume, description);
  if (!description.colors) description.type = SampleType::f32;
  std::unique_ptr<EvenDicomReader> reader(new EvenDicomReader(std::move(volume), std::move(description)));
  VolumeDescription& d = reader->description_;
  const std::vector<Vec3d>& places = reader->volume_.geometry.places;
  const Vec3d spacing = reader->volume_.geometry.spacing;
  Vec3d least(0.0), most(0.0);
  for (const Vec3d& place : places) {
    for (int axis = 0; axis < 3; ++axis) {
      least[axis] = std::min(least[axis], place[axis]);
      most[axis] = std::max(most[axis], place[axis]);
    }
  }
  const double step = even_step(reader->volume_.geometry);
  const double columns =
      static_cast<double>(d.dimensions.x) + std::ceil((most.x - least.x) / spacing.x - 1e-6);
  const double rows = static_cast<double>(d.dimensions.y) + std::ceil((most.y - least.y) / spacing.y - 1e-6);
  const double steps = std::max(std::round((most.z - least.z) / step), 1.0);
  if (!(columns <= kLongestAxis && rows <= kLongestAxis && steps < kLongestAxis)) {
    return file_error(
        d.path, "even slices: expected at most 65536 voxels along an axis, the slices lie too far apart");
  }
  d.dimensions = {static_cast<std::int64_t>(columns), static_cast<std::int64_t>(rows),
                  places.size() == 1 ? 1 : static_cast<std::int64_t>(steps) + 1};
  reader->first_x_ = least.x;
  reader->first_y_ = least.y;
  reader->step_ = places.size() == 1 ? step : (most.z - least.z) / steps;
  d.voxel_to_world = upright_place(reader->volume_.images, reader->volume_.slices.front(),
                                   reader->volume_.geometry, {least.x, least.y, 0}, reader->step_);
  d.remarks.push_back("its " + std::to_string(places.size()) + " slices are resampled to " +
                      std::to_string(d.dimensions.z) + " upright ones, " +
                      number_text(std::round(1000 * reader->step_) / 1000) + " mm apart");
  return std::unique_ptr<SliceReader>(std::move(reader));
}

/// Takes the place of the loaded slice that is not the neighbour of `slice`.
Result<const EvenDicomReader::Loaded*> EvenDicomReader::load(std::size_t slice) {
  const auto wanted = static_cast<std::int64_t>(slice);
  for (const Loaded& loaded : loaded_) {
    if (loaded.slice == wanted) return &loaded;
  }
  Loaded& loaded = loaded_[slice % 2];
  loaded.slice = -1;
  const DicomImage& image = volume_.image(slice);
  stored_.resize(stored_slice_bytes(image));
  GVX_TRY(pixels_.read_slice(image, volume_.frame(slice), stored_));
  loaded.values.resize(stored_.size() / sample_bytes(image.format.type()));
  DicomFrame frame = volume_.frame(slice);
  if (description_.colors) frame.slope = 1, frame.intercept = 0;
  rescale(image.format.type(), stored_, frame, loaded.values.data());
  loaded.slice = wanted;
  return &loaded;
}

/// Adds the slice, bilinearly, to all pixels of the grid that lie on it.
Status EvenDicomReader::add_slice(std::size_t slice, float weight) {
  GVX_ASSIGN(const Loaded* const loaded, load(slice));
  const std::int64_t columns = volume_.image(0).slice_columns(), rows = volume_.image(0).slice_rows();
  const Vec3d spacing = volume_.geometry.spacing, place = volume_.geometry.places[slice];
  const auto channels = static_cast<std::size_t>(description_.components);
  const double shift_x = (first_x_ - place.x) / spacing.x, shift_y = (first_y_ - place.y) / spacing.y;
  // Rounding must not push a pixel that lies on the border off it.
  constexpr double kTiny = 1e-6;
  for (std::int64_t y = 0; y < description_.dimensions.y; ++y) {
    const double v = static_cast<double>(y) + shift_y;
    if (v < -kTiny || v > static_cast<double>(rows - 1) + kTiny) continue;
    const std::int64_t v0 = std::clamp<std::int64_t>(static_cast<std::int64_t>(std::floor(v)), 0,
                                                     std::max<std::int64_t>(rows - 2, 0));
    const auto fy = static_cast<float>(std::clamp(v - static_cast<double>(v0), 0.0, 1.0));
    const std::int64_t v1 = std::min(v0 + 1, rows - 1);
    for (std::int64_t x = 0; x < description_.dimensions.x; ++x) {
      const double u = static_cast<double>(x) + shift_x;
      if (u < -kTiny || u > static_cast<double>(columns - 1) + kTiny) continue;
      const std::int64_t u0 = std::clamp<std::int64_t>(static_cast<std::int64_t>(std::floor(u)), 0,
                                                       std::max<std::int64_t>(columns - 2, 0));
      const auto fx = static_cast<float>(std::clamp(u - static_cast<double>(u0), 0.0, 1.0));
      const std::int64_t u1 = std::min(u0 + 1, columns - 1);
      const auto to = static_cast<std::size_t>(y * description_.dimensions.x + x);
      weight_[to] += weight;
      for (std::size_t c = 0; c < channels; ++c) {
        const auto value = [&](std::int64_t column, std::int64_t row) {
          return loaded->values[static_cast<std::size_t>(row * columns + column) * channels + c];
        };
        const float top = value(u0, v0) + fx * (value(u1, v0) - value(u0, v0));
        const float bottom = value(u0, v1) + fx * (value(u1, v1) - value(u0, v1));
        sum_[to * channels + c] += weight * (top + fy * (bottom - top));
      }
    }
  }
  return {};
}

Status EvenDicomReader::resample(std::int64_t z) {
  const std::vector<Vec3d>& places = volume_.geometry.places;
  const auto pixels = static_cast<std::size_t>(description_.dimensions.x * description_.dimensions.y);
  sum_.assign(pixels * static_cast<std::size_t>(description_.components), 0.0f);
  weight_.assign(pixels, 0.0f);
  const double along = static_cast<double>(z) * step_;
  const auto above = std::upper_bound(places.begin(), places.end(), along,
                                      [](double a, const Vec3d& place) { return a < place.z; });
  const auto next = static_cast<std::size_t>(above - places.begin());
  const std::size_t before = next == 0 ? 0 : next - 1;
  if (next >= places.size()) return add_slice(places.size() - 1, 1.0f);
  const double gap = places[next].z - places[before].z;
  const auto share = static_cast<float>(gap > 0 ? (along - places[before].z) / gap : 0);
  constexpr float kTiny = 1e-5f;
  if (share < 1 - kTiny) GVX_TRY(add_slice(before, 1 - share));
  if (share > kTiny) GVX_TRY(add_slice(next, share));
  return {};
}

void EvenDicomReader::hand_out(std::byte* out) const {
  const auto channels = static_cast<std::size_t>(description_.components);
  for (std::size_t i = 0; i < sum_.size(); ++i) {
    const float weight = weight_[i / channels];
    if (description_.colors) {
      const float value = weight > 0 ? std::clamp(sum_[i] / weight, 0.0f, 255.0f) : 0.0f;
      out[i] = static_cast<std::byte>(static_cast<std::uint8_t>(std::lround(value)));
    } else {
      const float value = weight > 0 ? sum_[i] / weight : std::numeric_limits<float>::quiet_NaN();
      std::memcpy(out + i * sizeof value, &value, sizeof value);
    }
  }
}

Status EvenDicomReader::read_slices(std::int64_t count, std::span<std::byte> out) {
  const std::size_t slice_size = slice_bytes(description_);
  GVX_TRY(check_read(*this, count, out));
  for (std::int64_t i = 0; i < count; ++i, ++next_slice_) {
    GVX_TRY(resample(next_slice_));
    hand_out(out.data() + static_cast<std::size_t>(i) * slice_size);
  }
  return {};
}

Status EvenDicomReader::rewind() {
  next_slice_ = 0;
  return {};
}

}  // namespace gvx::io
