#include "gvx/io/store_build.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <future>
#include <limits>
#include <vector>

#include "gvx/exec/parallel.h"
#include "gvx/store/pyramid.h"
#include "gvx/store/store_writer.h"

namespace gvx::io {
namespace {

// A batch of slices is read while the one before it is worked on; this much is enough to keep both busy.
constexpr std::uint64_t kBatchBytes = 16ull << 20;

/// stored = (sample - bias) / unit, rounded for integers.
struct Conversion {
  VoxelType type = VoxelType::u8;
  double bias = 0;
  double unit = 1;
};

VoxelType natural_type(SampleType type) {
  switch (sample_bytes(type)) {
    case 1:
      return VoxelType::u8;
    case 2:
      return VoxelType::u16;
    default:
      return VoxelType::f32;
  }
}

/// The conversion that keeps every sample, where there is one.
std::optional<Conversion> lossless_conversion(SampleType from, VoxelType to) {
  if (to == VoxelType::f32) return Conversion{to, 0, 1};
  if (natural_type(from) == VoxelType::f32 || sample_bytes(from) > voxel_bytes(to)) return std::nullopt;
  const double bias = from == SampleType::i8 ? -128 : from == SampleType::i16 ? -32768 : 0;
  return Conversion{to, bias, 1};
}

/// What the volume's voxels become; an error where they cannot be that.
Result<VoxelFormat> choose_format(const VolumeDescription& d, const StoreBuildOptions& options) {
  const auto components = static_cast<std::uint32_t>(d.components);
  if (options.labels) {
    const VoxelType type = natural_type(d.type);
    if (components != 1 || type == VoxelType::f32) {
      return Error{d.path + ": labels: expected one integer of 8 or 16 bits a voxel"};
    }
    if (options.type) return Error{d.path + ": labels keep their type: --type does not go with --labels"};
    return VoxelFormat{type, VoxelContent::labels, 1};
  }
  if (d.colors) {
    if (options.type) return Error{d.path + ": colours are kept as u8: --type does not go with them"};
    if (d.type != SampleType::u8) return Error{d.path + ": colours: expected u8 components"};
    return VoxelFormat{VoxelType::u8, VoxelContent::color, 4};
  }
  return VoxelFormat{options.type.value_or(natural_type(d.type)), VoxelContent::scalar, components};
}

/// Red, green and blue are multiplied by the opacity. Where there is none it is the brightest of the three,
/// so that black is nothing.
void premultiply(std::span<const std::byte> samples, std::size_t components, std::vector<std::byte>& voxels) {
  const auto* in = reinterpret_cast<const std::uint8_t*>(samples.data());
  const std::size_t count = samples.size() / components;
  voxels.resize(4 * count);
  auto* out = reinterpret_cast<std::uint8_t*>(voxels.data());
  for (std::size_t i = 0; i < count; ++i, in += components, out += 4) {
    const int opacity = components == 4 ? in[3] : std::max({in[0], in[1], in[2]});
    for (int c = 0; c < 3; ++c) {
      // Without an opacity of its own the colour is multiplied by it already.
      out[c] = components == 4 ? static_cast<std::uint8_t>((in[c] * opacity + 127) / 255) : in[c];
    }
    out[3] = static_cast<std::uint8_t>(opacity);
  }
}

/// Reads slices a batch ahead of whoever takes them.
class BatchReader {
 public:
  BatchReader(SliceReader& reader, std::int64_t batch)
      : reader_(reader), batch_(batch), slice_(slice_bytes(reader.description())) {
    begin_next();
  }
  ~BatchReader() {
    if (next_.valid()) next_.wait();
  }

  /// The next slices; empty after the last. Valid until the next call.
  Result<std::span<const std::byte>> take() {
    if (!next_.valid()) return std::span<const std::byte>{};
    const Status status = next_.get();
    std::swap(current_, reading_);
    if (!status.ok()) return status.error();
    begin_next();
    return std::span<const std::byte>(current_);
  }

 private:
  void begin_next() {
    const std::int64_t left = reader_.description().dimensions.z - reader_.next_slice();
    const std::int64_t count = std::min(batch_, left);
    if (count == 0) return;
    reading_.resize(static_cast<std::size_t>(count) * slice_);
    next_ = std::async(std::launch::async, [this, count] { return reader_.read_slices(count, reading_); });
  }

  SliceReader& reader_;
  std::int64_t batch_;
  std::uint64_t slice_;
  std::vector<std::byte> reading_, current_;
  std::future<Status> next_;
};

struct SampleRange {
  double minimum = std::numeric_limits<double>::infinity();
  double maximum = -std::numeric_limits<double>::infinity();
};

template <typename Sample>
Sample sample_at(std::span<const std::byte> samples, std::size_t i) {
  Sample v;
  std::memcpy(&v, samples.data() + i * sizeof(Sample), sizeof(Sample));
  return v;
}

void extend_range(SampleType type, std::span<const std::byte> samples, SampleRange& range) {
  with_sample_type(type, [&](auto zero) {
    using Sample = decltype(zero);
    for (std::size_t i = 0; i < samples.size() / sizeof(Sample); ++i) {
      const auto v = static_cast<double>(sample_at<Sample>(samples, i));
      if (!std::isfinite(v)) continue;
      range.minimum = std::min(range.minimum, v);
      range.maximum = std::max(range.maximum, v);
    }
  });
}

template <typename Sample, typename Voxel>
std::uint64_t convert_samples(std::span<const std::byte> samples, const Conversion& c, Voxel* out) {
  std::uint64_t not_finite = 0;
  for (std::size_t i = 0; i < samples.size() / sizeof(Sample); ++i) {
    auto v = static_cast<double>(sample_at<Sample>(samples, i));
    if constexpr (std::is_floating_point_v<Sample>) {
      if (!std::isfinite(v) || std::abs(v) > double(std::numeric_limits<float>::max())) {
        ++not_finite;
        v = 0;
      }
    }
    v = (v - c.bias) / c.unit;
    if constexpr (std::is_integral_v<Voxel>) {
      v = std::clamp(std::nearbyint(v), 0.0, double(std::numeric_limits<Voxel>::max()));
    }
    out[i] = static_cast<Voxel>(v);
  }
  return not_finite;
}

/// Converts a batch on all threads; returns how many samples were not finite.
std::uint64_t convert(const exec::Device& cpu, SampleType from, const Conversion& conversion,
                      std::span<const std::byte> samples, std::vector<std::byte>& voxels) {
  constexpr std::size_t kPiece = 1 << 16;
  const std::size_t count = samples.size() / sample_bytes(from);
  voxels.resize(count * voxel_bytes(conversion.type));
  std::atomic<std::uint64_t> not_finite{0};
  exec::parallel_for(cpu, (count + kPiece - 1) / kPiece, [&](std::size_t piece) {
    const std::size_t first = piece * kPiece, pieces = std::min(kPiece, count - first);
    const auto part = samples.subspan(first * sample_bytes(from), pieces * sample_bytes(from));
    with_sample_type(from, [&](auto sample) {
      with_voxel_type(conversion.type, [&](auto voxel) {
        using Voxel = decltype(voxel);
        not_finite += convert_samples<decltype(sample)>(part, conversion,
                                                        reinterpret_cast<Voxel*>(voxels.data()) + first);
      });
    });
  });
  return not_finite;
}

bool any_negative(SampleType type, std::span<const std::byte> samples) {
  SampleRange range;
  extend_range(type, samples, range);
  return range.minimum < 0;
}

bool same_bytes(SampleType from, const Conversion& c) {
  return (from == SampleType::u8 && c.type == VoxelType::u8) ||
         (from == SampleType::u16 && c.type == VoxelType::u16);
}

}  // namespace

Result<StoreBuildReport> build_store(const exec::Device& cpu, SliceReader& reader, const std::string& path,
                                     const StoreBuildOptions& options, const BuildProgress& progress) {
  const VolumeDescription& d = reader.description();
  store::VolumeInfo info;
  info.shape = store::TreeShape::covering(d.dimensions, options.n, options.m);
  GVX_ASSIGN(info.format, choose_format(d, options));
  info.codec = options.codec;
  info.voxel_to_world = d.voxel_to_world;
  info.anatomical = d.anatomical;
  info.source = std::filesystem::path(d.path).filename().string();

  const std::uint64_t slice = slice_bytes(d);
  const std::uint64_t batch =
      std::clamp<std::uint64_t>(kBatchBytes / slice, 1, static_cast<std::uint64_t>(d.dimensions.z));
  const std::uint64_t buffers =
      3 + voxel_bytes(info.format.type) / sample_bytes(d.type);  // read, read ahead, converted
  const std::uint64_t needed = store::PyramidBuilder::window_bytes(info) +
                               std::min(store::saturating_product(batch * buffers, slice), UINT64_MAX / 2);
  if (needed > options.memory_bytes) {
    return Error{d.path + ": building needs " + store::mebibytes(needed) + " of memory for slices of " +
                 std::to_string(d.dimensions.x) + " x " + std::to_string(d.dimensions.y) + " voxels; " +
                 store::mebibytes(options.memory_bytes) +
                 " are allowed (--memory), and smaller bricks (--brick) need less"};
  }

  Conversion conversion;
  const bool keeps_numbers = info.format.content != VoxelContent::scalar;
  const auto lossless = keeps_numbers ? std::optional(Conversion{info.format.type, 0, 1})
                                      : lossless_conversion(d.type, info.format.type);
  const std::uint64_t all = volume_bytes(d) * (lossless ? 1 : 2);
  std::uint64_t done = 0;
  const auto report_progress = [&](std::size_t bytes) {
    done += bytes;
    if (progress) progress(done, all);
  };
  if (lossless) {
    conversion = *lossless;
  } else {
    SampleRange range;
    {
      BatchReader batches(reader, static_cast<std::int64_t>(batch));
      while (true) {
        GVX_ASSIGN(const auto samples, batches.take());
        if (samples.empty()) break;
        extend_range(d.type, samples, range);
        report_progress(samples.size());
      }
    }
    GVX_TRY(reader.rewind());
    if (!(range.minimum <= range.maximum)) range = {0, 0};
    const double steps = info.format.type == VoxelType::u8 ? 255 : 65535;
    conversion = {info.format.type, range.minimum,
                  range.maximum > range.minimum ? (range.maximum - range.minimum) / steps : 1};
  }
  // Labels and colours are what they are: a slope means nothing for them.
  info.scale = keeps_numbers ? 1 : d.scale * conversion.unit;
  info.offset = keeps_numbers ? 0 : d.offset + d.scale * conversion.bias;

  StoreBuildReport report;
  report.rounded =
      info.format.type == VoxelType::f32 && sample_bytes(d.type) >= 4 && d.type != SampleType::f32;
  GVX_ASSIGN(const auto writer, store::StoreWriter::create(path, info.shape, info.format));
  store::PyramidBuilder pyramid(cpu, *writer, info);
  BatchReader batches(reader, static_cast<std::int64_t>(batch));
  std::vector<std::byte> voxels;
  while (true) {
    GVX_ASSIGN(const auto samples, batches.take());
    if (samples.empty()) break;
    const auto slices = static_cast<std::int64_t>(samples.size() / slice);
    if (info.format.content == VoxelContent::color) {
      premultiply(samples, static_cast<std::size_t>(d.components), voxels);
      GVX_TRY(pyramid.push_slices(slices, voxels));
    } else if (same_bytes(d.type, conversion)) {
      GVX_TRY(pyramid.push_slices(slices, samples));
    } else {
      if (options.labels && any_negative(d.type, samples)) {
        return Error{d.path + ": labels: expected none below 0"};
      }
      report.not_finite += convert(cpu, d.type, conversion, samples, voxels);
      GVX_TRY(pyramid.push_slices(slices, voxels));
    }
    report_progress(samples.size());
  }
  report.surplus = reader.surplus();
  GVX_TRY(pyramid.finish());
  report.bytes_written = writer->bytes_written();
  return report;
}

}  // namespace gvx::io
