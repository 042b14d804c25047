// gvx build beside what it is made of.
//
//     gvx_bench_build VOLUME.nhdr FOLDER
//
// Builds FOLDER/stages.gvx with all cores, then does alone what a build cannot do without: reading the
// voxels, compressing the same bricks with the same codec on all cores, and writing the store's bytes to the
// same disk. Prints JSON; `share` is the slowest of these three over the build.

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <vector>

#include <fcntl.h>
#include <unistd.h>

#include "gvx/exec/parallel.h"
#include "gvx/io/store_build.h"
#include "gvx/io/volume_reader.h"
#include "gvx/store/codec.h"
#include "gvx/store/store_reader.h"

namespace {

using namespace gvx;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

Result<double> reading(const std::string& path) {
  GVX_ASSIGN(const auto volume, io::open_volume(path, {}));
  const auto start = Clock::now();
  const io::VolumeDescription& d = volume->description();
  const std::int64_t batch = std::min<std::int64_t>(8, d.dimensions.z);
  std::vector<std::byte> slices(static_cast<std::size_t>(batch) * io::slice_bytes(d));
  for (std::int64_t z = 0; z < d.dimensions.z; z += batch) {
    const std::int64_t count = std::min(batch, d.dimensions.z - z);
    GVX_TRY(
        volume->read_slices(count, {slices.data(), static_cast<std::size_t>(count) * io::slice_bytes(d)}));
  }
  return seconds_since(start);
}

/// All bricks of a store, a batch at a time.
class Bricks {
 public:
  static constexpr std::size_t kBatch = 2048;

  explicit Bricks(const store::StoreReader& reader) : reader_(reader) {
    const store::TreeShape& shape = reader.info().shape;
    for (std::uint32_t level = 0; level < shape.levels; ++level) {
      const Vec3i nodes = shape.level_nodes(level);
      for (std::int64_t z = 0; z < nodes.z; ++z) {
        for (std::int64_t y = 0; y < nodes.y; ++y) {
          for (std::int64_t x = 0; x < nodes.x; ++x) {
            keys_.push_back({level, static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y),
                             static_cast<std::uint32_t>(z)});
          }
        }
      }
    }
  }

  /// The next that are no constants; none after the last.
  Result<std::vector<std::vector<std::byte>>> next() {
    std::vector<std::vector<std::byte>> bricks;
    for (; at_ < keys_.size() && bricks.size() < kBatch; ++at_) {
      GVX_ASSIGN(const store::NodeRecord record, reader_.node(keys_[at_]));
      if (record.constant()) continue;
      GVX_TRY(reader_.read_brick(keys_[at_], record, bricks.emplace_back(reader_.info().brick_bytes())));
    }
    return bricks;
  }

 private:
  const store::StoreReader& reader_;
  std::vector<NodeKey> keys_;
  std::size_t at_ = 0;
};

struct Parts {
  double compressing = 0, writing = 0;
  std::uint64_t bricks = 0, raw_bytes = 0;
};

Result<Parts> parts_of(const exec::Device& cpu, const std::string& store_path, const std::string& copy_path) {
  GVX_ASSIGN(const auto reader, store::StoreReader::open(store_path));
  const store::VolumeInfo& info = reader->info();
  const store::BlockLayout layout{voxel_bytes(info.format.type),
                                  info.format.planes * plane_texels(info.shape.m)};
  Bricks bricks(*reader);
  Parts parts;
  const int copy = open(copy_path.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
  if (copy < 0) return Error{copy_path + ": cannot create"};
  unlink(copy_path.c_str());  // gone with its descriptor, whatever happens
  while (true) {
    GVX_ASSIGN(const auto batch, bricks.next());
    if (batch.empty()) break;
    std::vector<std::vector<std::byte>> compressed(batch.size());
    auto start = Clock::now();
    exec::parallel_for(cpu, batch.size(),
                       [&](std::size_t i) { store::compress(info.codec, layout, batch[i], compressed[i]); });
    parts.compressing += seconds_since(start);
    std::vector<std::byte> bytes;
    for (std::size_t i = 0; i < batch.size(); ++i) {
      parts.raw_bytes += batch[i].size();
      bytes.insert(bytes.end(), compressed[i].begin(), compressed[i].end());
    }
    parts.bricks += batch.size();
    start = Clock::now();
    if (write(copy, bytes.data(), bytes.size()) != static_cast<ssize_t>(bytes.size())) {
      return Error{copy_path + ": cannot write"};
    }
    parts.writing += seconds_since(start);
  }
  const auto start = Clock::now();
  if (fsync(copy) != 0 || close(copy) != 0) return Error{copy_path + ": cannot write"};
  parts.writing += seconds_since(start);
  return parts;
}

Status run(const std::string& volume_path, const std::string& folder) {
  const exec::Device cpu = exec::Device::cpu(0);
  const std::string store_path = folder + "/stages.gvx";
  GVX_ASSIGN(const double read, reading(volume_path));
  GVX_ASSIGN(const auto volume, io::open_volume(volume_path, {}));
  const auto start = Clock::now();
  GVX_ASSIGN(const io::StoreBuildReport report, io::build_store(cpu, *volume, store_path, {}, {}));
  const double built = seconds_since(start);
  GVX_ASSIGN(const Parts parts, parts_of(cpu, store_path, folder + "/stages.copy"));
  const double slowest = std::max({read, parts.compressing, parts.writing});
  std::printf(
      "{\"threads\": %d, \"voxels_mib\": %.0f, \"bricks\": %llu, \"bricks_mib\": %.0f, \"store_mib\": %.0f,\n"
      " \"reading_s\": %.2f, \"compressing_s\": %.2f, \"writing_s\": %.2f, \"build_s\": %.2f, \"share\": "
      "%.2f}\n",
      cpu.threads(), static_cast<double>(io::volume_bytes(volume->description())) / (1 << 20),
      static_cast<unsigned long long>(parts.bricks), static_cast<double>(parts.raw_bytes) / (1 << 20),
      static_cast<double>(report.bytes_written) / (1 << 20), read, parts.compressing, parts.writing, built,
      slowest / built);
  unlink(store_path.c_str());
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: gvx_bench_build VOLUME FOLDER\n");
    return 2;
  }
  const Status status = run(argv[1], argv[2]);
  if (status.ok()) return 0;
  std::fprintf(stderr, "gvx_bench_build: %s\n", status.error().message.c_str());
  return 1;
}
