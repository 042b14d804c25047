#include "gvx/io/store_build.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <future>
#include <limits>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "gvx/exec/parallel.h"
#include "gvx/io/header_text.h"
#include "gvx/io/physical_values.h"
#include "gvx/io/sample_conversion.h"
#include "gvx/store/notes.h"
#include "gvx/store/pyramid.h"
#include "gvx/store/shape_check.h"
#include "gvx/store/store_writer.h"

namespace gvx::io {
namespace {

// A batch of slices is read while the one before it is worked on; this much is enough to keep both busy.
constexpr std::uint64_t kBatchBytes = 16ull << 20;

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

/// The conversion, where it does not depend on what the samples are.
std::optional<Conversion> known_conversion(SampleType from, const VoxelFormat& to) {
  if (to.content == VoxelContent::color) return Conversion{to.type, 0, 1};
  if (to.content == VoxelContent::labels) {
    return sample_bytes(from) <= voxel_bytes(to.type) ? std::optional(Conversion{to.type, 0, 1})
                                                      : std::nullopt;
  }
  if (to.type == VoxelType::f32)
    return is_wide(from) ? std::nullopt : std::optional(Conversion{to.type, 0, 1});
  if (natural_type(from) == VoxelType::f32 || sample_bytes(from) > voxel_bytes(to.type)) return std::nullopt;
  const double bias = from == SampleType::i8 ? -128 : from == SampleType::i16 ? -32768 : 0;
  return Conversion{to.type, bias, 1};
}

/// The conversions to f32 that may lose least, the plain one first unless another is never worse.
std::vector<Conversion> conversions_to_float(const Survey& survey) {
  // A sample that comes nearer to 0 keeps at least as many digits as it had.
  if (survey.finite.far_from_0()) return {to_float(survey, at_or_below(survey.finite.least))};
  std::vector<Conversion> conversions = {to_float(survey, 0)};
  // A float that is taken off a background of 0 loses nothing of that.
  if (survey.rounded.far_from_0())
    conversions.push_back(to_float(survey, float_at_or_below(survey.rounded.least)));
  return conversions;
}

/// The index of the conversion that loses least. Another than the first rounds what the first kept: it has to
/// be much better.
std::size_t most_faithful(std::span<const double> losses) {
  std::size_t best = 0;
  for (std::size_t i = 1; i < losses.size(); ++i) {
    if (losses[i] < std::min(losses[best], losses[0] / 4)) best = i;
  }
  return best;
}

/// What the volume's voxels become; an error where they cannot be that.
Result<VoxelFormat> choose_format(const VolumeDescription& d, const StoreBuildOptions& options) {
  const auto components = static_cast<std::uint32_t>(d.components);
  if (options.labels) {
    if (components != 1) {
      return Error{d.path + ": labels: expected one number a voxel, found " + std::to_string(components)};
    }
    if (options.type) return Error{d.path + ": labels keep their type: --type does not go with --labels"};
    return VoxelFormat{sample_bytes(d.type) == 1 ? VoxelType::u8 : VoxelType::u16, VoxelContent::labels, 1};
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

/// Pieces of a batch are worked on by all threads: calls function(piece of samples, index of its first
/// sample) and adds up what it returns.
template <typename Sum, typename Function>
Sum over_pieces(const exec::Device& cpu, SampleType type, std::span<const std::byte> samples,
                const Function& function) {
  constexpr std::size_t kPiece = 1 << 16;
  const std::size_t width = sample_bytes(type), count = samples.size() / width;
  Sum sum;
  std::mutex mutex;
  exec::parallel_for(cpu, (count + kPiece - 1) / kPiece, [&](std::size_t piece) {
    const std::size_t first = piece * kPiece;
    const Sum of_piece =
        function(samples.subspan(first * width, std::min(kPiece, count - first) * width), first);
    const std::lock_guard lock(mutex);
    sum.add(of_piece);
  });
  return sum;
}

Survey survey(const exec::Device& cpu, SampleType type, std::span<const std::byte> samples) {
  return over_pieces<Survey>(cpu, type, samples, [&](std::span<const std::byte> piece, std::size_t) {
    return with_sample_type(type, [&](auto sample) { return survey_samples<decltype(sample)>(piece); });
  });
}

/// NaN, that is no data, and what is infinite become NaN of f32, and of integers the least voxel, or the
/// greatest where `reversed`.
ConversionAccount convert(const exec::Device& cpu, SampleType from, const Conversion& conversion,
                          bool reversed, std::span<const std::byte> samples, std::vector<std::byte>& voxels) {
  voxels.resize(samples.size() / sample_bytes(from) * voxel_bytes(conversion.type));
  return over_pieces<ConversionAccount>(
      cpu, from, samples, [&](std::span<const std::byte> piece, std::size_t first) {
        return with_sample_type(from, [&](auto sample) {
          return with_voxel_type(conversion.type, [&](auto voxel) {
            using Voxel = decltype(voxel);
            using Limits = std::numeric_limits<Voxel>;
            const Voxel no_data = std::is_same_v<Voxel, float> ? Limits::quiet_NaN()
                                  : reversed                   ? Limits::max()
                                                               : Limits::min();
            return convert_samples<decltype(sample)>(piece, conversion, no_data,
                                                     reinterpret_cast<Voxel*>(voxels.data()) + first);
          });
        });
      });
}

/// Labels are stored as they are: an error where the voxels' type does not hold one.
Status check_labels(const VolumeDescription& d, const Survey& survey, VoxelType type) {
  if (survey.fraction != 0) {
    return Error{d.path + ": labels: expected whole numbers, found " +
                 number_text(static_cast<double>(survey.fraction))};
  }
  const Span& labels = survey.finite;
  const Exact most = type == VoxelType::u8 ? 255 : 65535;
  if (labels.empty() || (labels.least >= 0 && labels.greatest <= most)) return {};
  const Exact worst = labels.greatest > most ? labels.greatest : labels.least;
  return Error{d.path + ": labels: expected 0 to " + number_text(static_cast<double>(most)) + ", found " +
               (d.type == SampleType::f32 || d.type == SampleType::f64
                    ? number_text(static_cast<double>(worst))
                : worst < 0 ? std::to_string(static_cast<std::int64_t>(worst))
                            : std::to_string(static_cast<std::uint64_t>(worst)))};
}

/// Finds a conversion in passes over the samples before the one that stores them.
class Prospector {
 public:
  /// Counts its passes in `passes`, and says how many bytes of samples it has read.
  Prospector(const exec::Device& cpu, SliceReader& reader, std::int64_t batch, std::uint64_t& passes,
             std::function<void(std::size_t)> progress)
      : cpu_(cpu), reader_(reader), batch_(batch), passes_(passes), progress_(std::move(progress)) {}

  /// To the format's type; of labels to a narrower one where that holds them.
  Result<Conversion> find_conversion(VoxelFormat format) {
    Survey all;
    GVX_TRY(pass([&](std::span<const std::byte> samples) { all.add(survey(cpu_, type(), samples)); }));
    if (format.content == VoxelContent::labels) {
      GVX_TRY(check_labels(reader_.description(), all, format.type));
      return Conversion{all.finite.greatest <= 255 ? VoxelType::u8 : format.type, 0, 1};
    }
    if (format.type != VoxelType::f32) return to_integer(type(), all, format.type);
    const std::vector<Conversion> candidates = conversions_to_float(all);
    if (candidates.size() == 1) return candidates.front();
    std::vector<double> losses(candidates.size());
    std::vector<std::byte> voxels;
    GVX_TRY(pass([&](std::span<const std::byte> samples) {
      for (std::size_t i = 0; i < losses.size(); ++i) {
        losses[i] =
            std::max(losses[i], convert(cpu_, type(), candidates[i], false, samples, voxels).rounded_by);
      }
    }));
    return candidates[most_faithful(losses)];
  }

 private:
  SampleType type() const { return reader_.description().type; }

  template <typename Function>
  Status pass(const Function& function) {
    ++passes_;
    BatchReader batches(reader_, batch_);
    while (true) {
      GVX_ASSIGN(const auto samples, batches.take());
      if (samples.empty()) break;
      function(samples);
      progress_(samples.size());
    }
    return reader_.rewind();
  }

  const exec::Device& cpu_;
  SliceReader& reader_;
  std::int64_t batch_;
  std::uint64_t& passes_;
  std::function<void(std::size_t)> progress_;
};

/// Of channels, where there are as many as the store has.
store::VolumeNotes notes_of(const VolumeDescription& d, std::size_t channels) {
  store::VolumeNotes notes{d.unit, {}};
  if (d.channels.size() != channels) return notes;
  for (const ChannelDescription& channel : d.channels)
    notes.channels.push_back({channel.name, channel.color});
  return notes;
}

bool same_bytes(SampleType from, const Conversion& c) {
  return (from == SampleType::u8 && c.type == VoxelType::u8) ||
         (from == SampleType::u16 && c.type == VoxelType::u16);
}

}  // namespace

std::vector<std::string> StoreBuildReport::warnings(const std::string& path, SampleType type) const {
  std::vector<std::string> lines;
  if (not_finite > 0) {
    const std::string none = path + ": " + std::to_string(not_finite) + " voxels have no value (" +
                             (infinite == 0            ? "NaN"
                              : infinite == not_finite ? "infinite"
                                                       : "NaN or infinite") +
                             "): ";
    lines.push_back(none + (no_data_value ? "stored as the least value, " + number_text(*no_data_value) +
                                                "; with --type f32 they are transparent"
                                          : "shown as transparent"));
  }
  if (clamped > 0) {
    lines.push_back(path + ": " + std::to_string(clamped) +
                    " samples are beyond what the store's voxels hold; they are stored as the nearest value");
  }
  if (rounded > 0) {
    lines.push_back(path + ": " + std::to_string(rounded) + " " + sample_name(type) +
                    " samples are rounded to " + std::to_string(digits) + " significant digits");
  }
  return lines;
}

Result<StoreBuildReport> build_store(const exec::Device& cpu, SliceReader& reader, const std::string& path,
                                     const StoreBuildOptions& options, const BuildProgress& progress) {
  const VolumeDescription& d = reader.description();
  if (cpu.kind() != exec::DeviceKind::cpu)
    return Error{"build_store: runs on the CPU only; expected Device::cpu()"};
  GVX_TRY(store::check_tree(options.n, options.m));
  if (reader.next_slice() != 0)
    return file_error(d.path, "build_store: expected a reader at slice 0; rewind() it");
  if (options.labels && (d.scale != 1 || d.offset != 0)) {
    PhysicalValueReader physical(reader);
    return build_store(cpu, physical, path, options, progress);
  }
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

  const bool keeps_numbers = info.format.content != VoxelContent::scalar;
  std::uint64_t done = 0, passes = 1;
  const auto report_progress = [&](std::size_t bytes) {
    done += bytes;
    if (progress) progress(done, passes * volume_bytes(d));
  };
  std::optional<Conversion> conversion = known_conversion(d.type, info.format);
  if (!conversion) {
    if (reader.can_rewind()) {
      Prospector prospector(cpu, reader, static_cast<std::int64_t>(batch), passes, report_progress);
      GVX_ASSIGN(conversion, prospector.find_conversion(info.format));
      info.format.type = conversion->type;
    } else if (info.format.content == VoxelContent::labels) {
      conversion = Conversion{info.format.type, 0, 1};
    } else if (info.format.type != VoxelType::f32) {
      return file_error(d.path, "--type: expected a file, not a pipe: the range of its values must be known");
    }
  }

  BatchReader batches(reader, static_cast<std::int64_t>(batch));
  GVX_ASSIGN(auto samples, batches.take());
  if (!conversion) {
    // Of a pipe's samples, which come but once, the first stand for all.
    const std::vector<Conversion> candidates = conversions_to_float(survey(cpu, d.type, samples));
    std::vector<double> losses;
    std::vector<std::byte> voxels;
    for (const Conversion& candidate : candidates) {
      losses.push_back(convert(cpu, d.type, candidate, false, samples, voxels).rounded_by);
    }
    conversion = candidates[most_faithful(losses)];
  }
  // Labels are physical values already. Colours are what they are: a slope means nothing for them.
  info.scale = keeps_numbers ? 1 : d.scale * conversion->unit;
  info.offset = keeps_numbers ? 0 : d.offset + d.scale * conversion->bias;
  if (!std::isnormal(info.scale) || !std::isfinite(info.offset)) {
    return Error{d.path + ": value scale: expected physical values that a double can hold"};
  }

  ConversionAccount account;
  StoreBuildReport report;
  GVX_ASSIGN(const auto writer, store::StoreWriter::create(path, info.shape, info.format));
  store::PyramidBuilder pyramid(cpu, *writer, info);
  std::vector<std::byte> voxels;
  while (!samples.empty()) {
    const auto slices = static_cast<std::int64_t>(samples.size() / slice);
    if (info.format.content == VoxelContent::color) {
      premultiply(samples, static_cast<std::size_t>(d.components), voxels);
      GVX_TRY(pyramid.push_slices(slices, voxels));
    } else if (same_bytes(d.type, *conversion)) {
      GVX_TRY(pyramid.push_slices(slices, samples));
    } else {
      if (options.labels) GVX_TRY(check_labels(d, survey(cpu, d.type, samples), info.format.type));
      account.add(convert(cpu, d.type, *conversion, d.scale < 0, samples, voxels));
      GVX_TRY(pyramid.push_slices(slices, voxels));
    }
    report_progress(samples.size());
    GVX_ASSIGN(samples, batches.take());
  }
  report.surplus = reader.surplus();
  GVX_TRY(store::write_notes(*writer, notes_of(d, info.format.channels())));
  GVX_TRY(pyramid.finish());
  report.bytes_written = writer->bytes_written();
  report.not_finite = account.not_finite;
  report.infinite = account.infinite;
  if (info.format.type != VoxelType::f32) {
    const double most = info.format.type == VoxelType::u8 ? 255 : 65535;
    report.no_data_value = info.offset + (d.scale < 0 ? info.scale * most : 0);
  }
  report.clamped = account.clamped;
  report.rounded = account.rounded;
  if (account.rounded > 0) {
    const Span& rounded = account.rounded_samples;
    const auto greatest = static_cast<double>(std::max(std::abs(d.scale * rounded.least + d.offset),
                                                       std::abs(d.scale * rounded.greatest + d.offset)));
    report.digits = static_cast<int>(std::log10(greatest / (std::abs(d.scale) * account.rounded_by)));
  }
  return report;
}

}  // namespace gvx::io
