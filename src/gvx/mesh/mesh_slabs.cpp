#include "gvx/mesh/mesh_slabs.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "gvx/io/scratch_file.h"

namespace gvx::mesh {
namespace {

/// A voxel sees no surface that is farther away.
constexpr float kNear = 2;
/// Rows are cut up only where a block of slices is too much, and into no more parts than this.
constexpr std::int64_t kMostStrips = 64;

/// From where to where along an axis voxels may see a triangle.
struct Reach {
  float low, high;

  Reach(const std::array<Vec3f, 3>& corners, int axis) {
    std::tie(low, high) = std::minmax({corners[0][axis], corners[1][axis], corners[2][axis]});
    low -= kNear;
    high += kNear;
  }
};

/// Those between two numbers, both included.
struct Span {
  std::int64_t first, last;
};

/// How many triangles are near to each block of slices, and to each strip of rows in it.
class SlabPlan {
 public:
  explicit SlabPlan(const Vec3i& dimensions)
      : dimensions_(dimensions),
        strip_rows_(MeshSlabs::kBlock * ((dimensions.y + MeshSlabs::kBlock * kMostStrips - 1) /
                                         (MeshSlabs::kBlock * kMostStrips))),
        layers_((dimensions.z + MeshSlabs::kBlock - 1) / MeshSlabs::kBlock),
        strips_((dimensions.y + strip_rows_ - 1) / strip_rows_),
        starting_(static_cast<std::size_t>(layers_)),
        near_(static_cast<std::size_t>((layers_ + 1) * (strips_ + 1))),
        first_in_(near_.size()) {}

  void count(const std::array<Vec3f, 3>& corners) {
    const Span z = cells(Reach(corners, 2), dimensions_.z, MeshSlabs::kBlock);
    const Span y = cells(Reach(corners, 1), dimensions_.y, strip_rows_);
    ++starting_[static_cast<std::size_t>(z.first)];
    // Of what is counted, differences: a triangle may be near to all.
    ++at(first_in_, z.first, y.first);
    --at(first_in_, z.last + 1, y.first);
    ++at(near_, z.first, y.first);
    --at(near_, z.first, y.last + 1);
    --at(near_, z.last + 1, y.first);
    ++at(near_, z.last + 1, y.last + 1);
  }

  /// Called once, after everything is counted. Nothing where a strip of a block has too many.
  std::vector<MeshSlabs::Slab> cut(std::uint64_t most) {
    sum_up();
    std::vector<MeshSlabs::Slab> slabs;
    bool open = false;  // may the last slab grow?
    for (std::int64_t layer = 0; layer < layers_; ++layer) {
      const std::int64_t z = layer * MeshSlabs::kBlock,
                         z_end = std::min(z + MeshSlabs::kBlock, dimensions_.z);
      const std::uint64_t starting = starting_[static_cast<std::size_t>(layer)];
      std::uint64_t all = 0;
      for (std::int64_t strip = 0; strip < strips_; ++strip) all += count_at(first_in_, layer, strip);
      if (open && slabs.back().count + starting <= most) {
        slabs.back().z_end = z_end;
        slabs.back().count += starting;
      } else if (all <= most) {
        slabs.push_back({z, z_end, 0, dimensions_.y, 0, all});
        open = true;
      } else {
        open = false;
        if (!cut_rows(layer, z, z_end, most, slabs)) return {};
      }
    }
    std::uint64_t first = 0;
    for (MeshSlabs::Slab& slab : slabs) {
      slab.first = first;
      first += slab.count;
    }
    return slabs;
  }

 private:
  std::int64_t& at(std::vector<std::int64_t>& counts, std::int64_t layer, std::int64_t strip) const {
    return counts[static_cast<std::size_t>(layer * (strips_ + 1) + strip)];
  }
  std::uint64_t count_at(std::vector<std::int64_t>& counts, std::int64_t layer, std::int64_t strip) const {
    return static_cast<std::uint64_t>(at(counts, layer, strip));
  }

  static Span cells(const Reach& reach, std::int64_t size, std::int64_t cell) {
    const auto cell_of = [&](float v) {
      return static_cast<std::int64_t>(std::clamp(std::floor(v), 0.0f, static_cast<float>(size - 1))) / cell;
    };
    return {cell_of(reach.low), cell_of(reach.high)};
  }

  void sum_up() {
    for (std::int64_t layer = 0; layer <= layers_; ++layer) {
      for (std::int64_t strip = 0; strip <= strips_; ++strip) {
        if (layer > 0) {
          at(first_in_, layer, strip) += at(first_in_, layer - 1, strip);
          at(near_, layer, strip) += at(near_, layer - 1, strip);
        }
      }
    }
    for (std::int64_t layer = 0; layer <= layers_; ++layer) {
      for (std::int64_t strip = 1; strip <= strips_; ++strip) {
        at(near_, layer, strip) += at(near_, layer, strip - 1);
      }
    }
  }

  bool cut_rows(std::int64_t layer, std::int64_t z, std::int64_t z_end, std::uint64_t most,
                std::vector<MeshSlabs::Slab>& slabs) {
    for (std::int64_t strip = 0; strip < strips_; ++strip) {
      const std::int64_t y = strip * strip_rows_, y_end = std::min(y + strip_rows_, dimensions_.y);
      const std::uint64_t starting = count_at(first_in_, layer, strip);
      if (strip > 0 && slabs.back().count + starting <= most) {
        slabs.back().y_end = y_end;
        slabs.back().count += starting;
      } else {
        slabs.push_back({z, z_end, y, y_end, 0, count_at(near_, layer, strip)});
      }
      if (slabs.back().count > most) return false;
    }
    return true;
  }

  Vec3i dimensions_;
  std::int64_t strip_rows_, layers_, strips_;
  std::vector<std::uint64_t> starting_;  // triangles of which this is the first block
  std::vector<std::int64_t> near_;       // triangles near to a strip of a block
  std::vector<std::int64_t> first_in_;   // those near to a block of which this is the first strip
};

/// Puts each triangle where those of all slabs are that it is near to.
class SlabWriter {
 public:
  SlabWriter(const std::vector<MeshSlabs::Slab>& slabs, io::ScratchFile& file, std::uint64_t memory_bytes)
      : slabs_(slabs), file_(file), parts_(slabs.size()) {
    const std::uint64_t records =
        memory_bytes / sizeof(SlabTriangle) / std::max<std::size_t>(slabs.size(), 1);
    most_waiting_ = static_cast<std::size_t>(std::clamp<std::uint64_t>(records, 16, 1 << 14));
  }

  Status push(const SlabTriangle& triangle) {
    const Reach y(triangle.corners, 1), z(triangle.corners, 2);
    // Slabs are in the order of their ends.
    auto slab = std::partition_point(slabs_.begin(), slabs_.end(), [&](const MeshSlabs::Slab& s) {
      return static_cast<float>(s.z_end) <= z.low;
    });
    for (; slab != slabs_.end() && static_cast<float>(slab->z_begin) <= z.high; ++slab) {
      if (static_cast<float>(slab->y_end) <= y.low || static_cast<float>(slab->y_begin) > y.high) continue;
      const auto index = static_cast<std::size_t>(slab - slabs_.begin());
      std::vector<SlabTriangle>& waiting = parts_[index].waiting;
      if (waiting.capacity() == 0) waiting.reserve(most_waiting_);
      waiting.push_back(triangle);
      if (waiting.size() == most_waiting_) GVX_TRY(write(index));
    }
    return {};
  }

  Status finish() {
    for (std::size_t i = 0; i < slabs_.size(); ++i) {
      GVX_TRY(write(i));
      GVX_CHECK(parts_[i].written == slabs_[i].count);
    }
    return {};
  }

 private:
  struct Part {
    std::uint64_t written = 0;
    std::vector<SlabTriangle> waiting;
  };

  Status write(std::size_t index) {
    Part& part = parts_[index];
    GVX_TRY(file_.write((slabs_[index].first + part.written) * sizeof(SlabTriangle),
                        std::as_bytes(std::span(part.waiting))));
    part.written += part.waiting.size();
    part.waiting.clear();
    return {};
  }

  const std::vector<MeshSlabs::Slab>& slabs_;
  io::ScratchFile& file_;
  std::vector<Part> parts_;
  std::size_t most_waiting_ = 0;
};

}  // namespace

Result<std::optional<MeshSlabs>> MeshSlabs::sort(const MeshSpool& mesh, const Space& space,
                                                 std::uint64_t memory_bytes, std::uint64_t most,
                                                 const MeshBuildProgress& progress) {
  constexpr std::size_t kBuffer = 4096;
  const std::uint64_t all = mesh.summary().triangles;
  const auto placed = [&](const SpooledTriangle& triangle) {
    return corners_in(triangle, space.origin, space.voxel);
  };
  const auto report = [&](std::uint64_t done) {
    if (progress && done % 1024 == 0) progress("sorting", done, 2 * all);
  };

  SlabPlan plan(space.dimensions);
  CornerNormals normals(mesh.folder(), memory_bytes / 4 * 3, all);
  io::ScratchReader<SpooledTriangle> first(mesh.triangles(), 0, all, kBuffer);
  for (std::uint64_t i = 0; i < all; ++i) {
    GVX_ASSIGN(const SpooledTriangle* triangle, first.next());
    const std::array<Vec3f, 3> corners = placed(*triangle);
    plan.count(corners);
    GVX_TRY(normals.push(corners));
    report(i);
  }
  std::vector<Slab> slabs = plan.cut(most);
  if (slabs.empty()) return std::optional<MeshSlabs>();

  GVX_ASSIGN(io::ScratchFile file, io::ScratchFile::create(mesh.folder()));
  SlabWriter writer(slabs, file, memory_bytes / 4);
  io::ScratchReader<SpooledTriangle> second(mesh.triangles(), 0, all, kBuffer);
  std::uint64_t done = 0;
  GVX_TRY(normals.for_each([&](const std::array<Normal16, 3>& of_corners) -> Status {
    GVX_ASSIGN(const SpooledTriangle* triangle, second.next());
    report(all + done++);
    return writer.push({placed(*triangle), of_corners, triangle->colors});
  }));
  GVX_TRY(writer.finish());
  return std::optional(MeshSlabs(std::move(slabs), std::move(file)));
}

Status MeshSlabs::read(const Slab& slab, std::uint64_t index, std::span<SlabTriangle> out) const {
  GVX_CHECK(index + out.size() <= slab.count);
  return triangles_.read((slab.first + index) * sizeof(SlabTriangle), std::as_writable_bytes(out));
}

}  // namespace gvx::mesh
