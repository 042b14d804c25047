#include "gvx/produce/mesh_spool.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

namespace gvx::produce {
namespace {

constexpr std::uint64_t kBlockVertices = 512;

/// Bits that depend on all of h (Appleby's MurmurHash3, its finalizer).
std::uint64_t mixed(std::uint64_t h) {
  h = (h ^ (h >> 33)) * 0xff51afd7ed558ccdull;
  h = (h ^ (h >> 33)) * 0xc4ceb9fe1a85ec53ull;
  return h ^ (h >> 33);
}

std::array<float, 3> key(Vec3f v) {
  return {v.x, v.y, v.z};
}

/// Of an edge between two places, whichever comes first.
std::uint64_t edge_hash(Vec3f a, Vec3f b, std::uint64_t seed) {
  std::uint64_t hash = seed;
  for (const auto& end : {std::min(key(a), key(b)), std::max(key(a), key(b))}) {
    // The two zeros are one place.
    for (const float v : end)
      hash = mixed(hash + 0x9e3779b97f4a7c15ull + std::bit_cast<std::uint32_t>(v + 0.0f));
  }
  return hash;
}

Rgb8 bytes_of(Vec3f color) {
  const auto byte = [](float c) { return static_cast<std::uint8_t>(std::lround(255 * c)); };
  return {byte(color.x), byte(color.y), byte(color.z)};
}

}  // namespace

Result<std::unique_ptr<MeshSpool>> MeshSpool::create(const std::string& folder, std::uint64_t memory_bytes,
                                                     Keep keep) {
  GVX_ASSIGN(auto vertices, io::ScratchList<Vertex>::create(folder));
  GVX_ASSIGN(auto triangles, io::ScratchList<SpooledTriangle>::create(folder));
  return std::unique_ptr<MeshSpool>(
      new MeshSpool(folder, memory_bytes, keep, std::move(vertices), std::move(triangles)));
}

MeshSpool::MeshSpool(std::string folder, std::uint64_t memory_bytes, Keep keep,
                     io::ScratchList<Vertex> vertices, io::ScratchList<SpooledTriangle> triangles)
    : folder_(std::move(folder)),
      keep_(keep),
      most_blocks_(std::max<std::uint64_t>(memory_bytes / 2 / (kBlockVertices * sizeof(Vertex)), 8)),
      vertices_(std::move(vertices)),
      triangles_(std::move(triangles)) {}

void MeshSpool::make_room() {
  const std::uint64_t there = (vertices_->size() + kBlockVertices - 1) / kBlockVertices;
  const auto wanted = static_cast<std::size_t>(std::min(there, most_blocks_));
  if (wanted <= blocks_.size()) return;
  blocks_.assign(wanted, Block());
  of_blocks_ = std::make_unique_for_overwrite<std::byte[]>(wanted * kBlockVertices * sizeof(Vertex));
}

Status MeshSpool::add_vertices(std::span<const Vec3f> places, std::span<const Vec3f> colors) {
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

Status MeshSpool::add_triangles(std::span<const io::Triangle> triangles) {
  GVX_TRY(vertices_->flush());
  make_room();
  for (const io::Triangle& t : triangles) {
    if (std::any_of(t.begin(), t.end(), [&](std::uint32_t v) { return v >= vertices_->size(); })) {
      ++summary_.dropped;
      continue;
    }
    SpooledTriangle triangle;
    for (std::size_t k = 0; k < 3; ++k) {
      GVX_ASSIGN(const Vertex corner, vertex(t[k]));
      triangle.corners[k] = corner.place;
      triangle.colors[k] = corner.color;
    }
    const auto& [a, b, c] = triangle.corners;
    if (!io::has_area(a, b, c)) {
      ++summary_.dropped;
      continue;
    }
    take_into_account(triangle);
    ++summary_.triangles;
    if (keep_ == Keep::triangles) GVX_TRY(triangles_.push(triangle));
  }
  return {};
}

void MeshSpool::take_into_account(const SpooledTriangle& triangle) {
  const auto& corners = triangle.corners;
  for (std::size_t k = 0; k < 3; ++k) {
    for (int axis = 0; axis < 3; ++axis) {
      summary_.bounds.minimum[axis] = std::min(summary_.bounds.minimum[axis], double(corners[k][axis]));
      summary_.bounds.maximum[axis] = std::max(summary_.bounds.maximum[axis], double(corners[k][axis]));
    }
    // Two of a kind take each other out; that others do so by chance is as likely as to guess 128 bits.
    for (std::size_t i = 0; i < odd_.size(); ++i) odd_[i] ^= edge_hash(corners[k], corners[(k + 1) % 3], i);
  }
  const Vec3d a(corners[0]), b(corners[1]), c(corners[2]);
  const double area = length(cross(b - a, c - a));
  area_ += area;
  for (const Rgb8& color : triangle.colors) {
    color_ = color_ + area / 765 * Vec3d(color[0], color[1], color[2]);
  }
}

Status MeshSpool::finish() {
  GVX_TRY(triangles_.flush());
  blocks_ = std::vector<Block>();
  of_blocks_.reset();
  summary_.vertices = vertices_->size();
  vertices_.reset();
  summary_.closed = odd_[0] == 0 && odd_[1] == 0 && summary_.triangles > 0;
  summary_.mean_color = area_ > 0 ? Vec3f(color_ / area_) : Vec3f();
  return {};
}

Result<std::unique_ptr<MeshSpool>> spool_mesh(const std::string& path, const std::string& folder,
                                              std::uint64_t memory_bytes, MeshSpool::Keep keep,
                                              const io::MeshProgress& progress) {
  GVX_ASSIGN(auto spool, MeshSpool::create(folder, memory_bytes, keep));
  GVX_TRY(io::stream_mesh(path, *spool, progress));
  GVX_TRY(spool->finish());
  if (spool->summary().triangles == 0) return Error{path + ": there is no triangle in it"};
  return spool;
}

}  // namespace gvx::produce
