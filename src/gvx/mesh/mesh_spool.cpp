#include "gvx/mesh/mesh_spool.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "gvx/io/external_sort.h"

namespace gvx::mesh {
namespace {

constexpr std::uint64_t kBlockVertices = 512;
constexpr std::size_t kReadAtOnce = 4096;

Rgb8 bytes_of(Vec3f color) {
  const auto byte = [](float c) { return static_cast<std::uint8_t>(std::lround(255 * c)); };
  return {byte(color.x), byte(color.y), byte(color.z)};
}

}  // namespace

Result<std::unique_ptr<MeshSpool>> MeshSpool::create(const std::string& folder, std::uint64_t memory_bytes) {
  GVX_ASSIGN(auto vertices, io::ScratchList<Vertex>::create(folder));
  GVX_ASSIGN(auto triangles, io::ScratchList<SpooledTriangle>::create(folder));
  GVX_ASSIGN(auto slivers, io::ScratchList<EdgeSums::Corners>::create(folder));
  return std::unique_ptr<MeshSpool>(
      new MeshSpool(folder, memory_bytes, std::move(vertices), std::move(triangles), std::move(slivers)));
}

MeshSpool::MeshSpool(std::string folder, std::uint64_t memory_bytes, io::ScratchList<Vertex> vertices,
                     io::ScratchList<SpooledTriangle> triangles, io::ScratchList<EdgeSums::Corners> slivers)
    : folder_(std::move(folder)),
      memory_bytes_(memory_bytes),
      most_blocks_(std::max<std::uint64_t>(memory_bytes / 2 / (kBlockVertices * sizeof(Vertex)), 8)),
      vertices_(std::move(vertices)),
      triangles_(std::move(triangles)),
      slivers_(std::move(slivers)) {}

void MeshSpool::make_room() {
  const std::uint64_t there = (vertices_->size() + kBlockVertices - 1) / kBlockVertices;
  const auto wanted = static_cast<std::size_t>(std::min(there, most_blocks_));
  if (wanted <= blocks_.size()) return;
  blocks_.assign(wanted, Block());
  of_blocks_ = std::make_unique_for_overwrite<std::byte[]>(wanted * kBlockVertices * sizeof(Vertex));
}

Status MeshSpool::add_vertices(std::span<const Vec3d> places, std::span<const Vec3f> colors) {
  summary_.colors = summary_.colors || !colors.empty();
  for (std::size_t i = 0; i < places.size(); ++i) {
    GVX_TRY(vertices_->push({places[i], colors.empty() ? kPlainColor : bytes_of(colors[i])}));
  }
  return {};
}

Result<MeshSpool::Vertex> MeshSpool::vertex(std::uint32_t index) {
  const std::uint64_t number = index / kBlockVertices;
  const auto at = static_cast<std::size_t>(index % kBlockVertices);
  const auto place = static_cast<std::size_t>(number % blocks_.size());
  Block& block = blocks_[place];
  Vertex* vertices = reinterpret_cast<Vertex*>(of_blocks_.get()) + place * kBlockVertices;
  if (block.number != number || at >= block.vertices) {
    const std::uint64_t first = number * kBlockVertices;
    const auto count = static_cast<std::size_t>(std::min(kBlockVertices, vertices_->size() - first));
    block = {};
    GVX_TRY(vertices_->read(first, {vertices, count}));
    block = {number, count};
  }
  return vertices[at];
}

Result<Vec3d> MeshSpool::place(std::uint32_t index) {
  if (index >= vertices_->size()) return Vec3d(std::numeric_limits<double>::quiet_NaN());
  GVX_TRY(vertices_->flush());
  make_room();
  GVX_ASSIGN(const Vertex found, vertex(index));
  return found.place;
}

void MeshSpool::pass_over(const std::string& what) {
  std::vector<std::string>& unused = summary_.unused;
  if (std::find(unused.begin(), unused.end(), what) == unused.end()) unused.push_back(what);
}

Status MeshSpool::add_triangles(std::span<const io::Triangle> triangles, std::span<const Vec3f> colors) {
  GVX_TRY(vertices_->flush());
  make_room();
  summary_.colors = summary_.colors || !colors.empty();
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const io::Triangle& t = triangles[i];
    if (std::any_of(t.begin(), t.end(), [&](std::uint32_t v) { return v >= vertices_->size(); })) {
      ++summary_.dropped;
      continue;
    }
    SpooledTriangle triangle;
    for (std::size_t k = 0; k < 3; ++k) {
      GVX_ASSIGN(const Vertex corner, vertex(t[k]));
      triangle.corners[k] = corner.place;
      triangle.colors[k] = colors.empty() ? corner.color : bytes_of(colors[i]);
    }
    const auto& [a, b, c] = triangle.corners;
    if (io::has_area(a, b, c)) {
      judge_.add(triangle.corners);
      take_into_account(triangle);
      ++summary_.triangles;
      GVX_TRY(triangles_->push(triangle));
      continue;
    }
    ++summary_.dropped;
    const bool sliver = std::isfinite(length(a)) && std::isfinite(length(b)) && std::isfinite(length(c)) &&
                        a != b && b != c && c != a;
    if (!sliver) continue;
    judge_.add(triangle.corners);
    GVX_TRY(slivers_.push(triangle.corners));
  }
  return {};
}

void MeshSpool::take_into_account(const SpooledTriangle& triangle) {
  const auto& [a, b, c] = triangle.corners;
  for (const Vec3d& corner : triangle.corners) {
    for (int axis = 0; axis < 3; ++axis) {
      summary_.bounds.minimum[axis] = std::min(summary_.bounds.minimum[axis], corner[axis]);
      summary_.bounds.maximum[axis] = std::max(summary_.bounds.maximum[axis], corner[axis]);
    }
  }
  const double area = length(cross(b - a, c - a));
  area_ += area;
  for (const Rgb8& color : triangle.colors) {
    color_ = color_ + area / 765 * Vec3d(color[0], color[1], color[2]);
  }
}

Status MeshSpool::finish() {
  GVX_TRY(triangles_->flush());
  GVX_TRY(slivers_.flush());
  blocks_ = std::vector<Block>();
  of_blocks_.reset();
  summary_.vertices = vertices_->size();
  vertices_.reset();
  if (!judge_.settled() && summary_.triangles > 0) GVX_TRY(settle_inside());
  summary_.inside = summary_.triangles > 0 ? judge_.rule() : InsideRule::none;
  summary_.mean_color = area_ > 0 ? Vec3f(color_ / area_) : Vec3f();
  return {};
}

template <typename Function>
Status MeshSpool::for_each_face(const Function& function) const {
  std::uint64_t index = 0;
  io::ScratchReader<SpooledTriangle> triangles(*triangles_, 0, triangles_->size(), kReadAtOnce);
  while (true) {
    GVX_ASSIGN(const SpooledTriangle* triangle, triangles.next());
    if (triangle == nullptr) break;
    GVX_TRY(function(triangle->corners, index++));
  }
  io::ScratchReader<EdgeSums::Corners> slivers(slivers_, 0, slivers_.size(), kReadAtOnce);
  while (true) {
    GVX_ASSIGN(const EdgeSums::Corners* sliver, slivers.next());
    if (sliver == nullptr) return {};
    GVX_TRY(function(*sliver, index++));
  }
}

Status MeshSpool::weld_open_edges() {
  OpenEdges edges;
  {
    const std::uint64_t count = 3 * (triangles_->size() + slivers_.size());
    io::ExternalSorter<EdgeRecord, std::less<>> records(folder_, memory_bytes_ / 2, count, {});
    const auto push = [&](const EdgeRecord& record) { return records.push(record); };
    GVX_TRY(for_each_face([&](const EdgeSums::Corners& corners, std::uint64_t index) {
      return for_each_edge(corners, index, push);
    }));
    GVX_TRY(records.for_each([&](const EdgeRecord& record) {
      edges.take(record);
      return Status();
    }));
  }
  const std::vector<std::uint64_t> open = edges.finish();
  std::vector<std::array<Vec3d, 2>> places;
  auto next = open.begin();
  GVX_TRY(for_each_face([&](const EdgeSums::Corners& corners, std::uint64_t index) {
    for (; next != open.end() && *next / 3 == index; ++next) {
      places.push_back({corners[*next % 3], corners[(*next + 1) % 3]});
    }
    return Status();
  }));
  judge_.weld(places, weld_distance(summary_.bounds));
  return {};
}

Status MeshSpool::settle_inside() {
  if (judge_.may_weld()) GVX_TRY(weld_open_edges());
  if (judge_.settled()) return {};
  const std::uint64_t count = triangles_->size() + slivers_.size();
  {
    io::ExternalSorter<FaceRecord, std::less<>> records(folder_, memory_bytes_ / 2, count, {});
    GVX_TRY(for_each_face([&](const EdgeSums::Corners& corners, std::uint64_t index) {
      return records.push(FaceRecord::of(corners, index));
    }));
    GVX_TRY(records.for_each([&](const FaceRecord& record) {
      judge_.take(record, count);
      return Status();
    }));
  }
  GVX_TRY(for_each_face([&](const EdgeSums::Corners& corners, std::uint64_t index) {
    judge_.weigh(corners, index);
    return Status();
  }));

  for (std::uint64_t i = 0; i < triangles_->size(); ++i) summary_.doubled += judge_.is_spare(i) ? 1 : 0;
  if (summary_.doubled == 0) return {};
  GVX_ASSIGN(auto kept, io::ScratchList<SpooledTriangle>::create(folder_));
  io::ScratchReader<SpooledTriangle> triangles(*triangles_, 0, triangles_->size(), kReadAtOnce);
  for (std::uint64_t i = 0; i < triangles_->size(); ++i) {
    GVX_ASSIGN(const SpooledTriangle* triangle, triangles.next());
    if (!judge_.is_spare(i)) GVX_TRY(kept.push(*triangle));
  }
  GVX_TRY(kept.flush());
  summary_.triangles = kept.size();
  triangles_.emplace(std::move(kept));
  return {};
}

Result<std::unique_ptr<MeshSpool>> spool_mesh(const std::string& path, const std::string& folder,
                                              std::uint64_t memory_bytes, const io::MeshProgress& progress) {
  GVX_ASSIGN(auto spool, MeshSpool::create(folder, memory_bytes));
  GVX_TRY(io::stream_mesh(path, *spool, progress));
  GVX_TRY(spool->finish());
  if (spool->summary().triangles == 0) {
    Error error = io::no_triangle(path, spool->summary().dropped);
    for (const std::string& what : spool->summary().unused) error.message += "; not used: " + what;
    return error;
  }
  return spool;
}

}  // namespace gvx::mesh
