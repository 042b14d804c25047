#include "models.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <span>
#include <tuple>
#include <unordered_map>
#include <utility>

#include <tbb/parallel_sort.h>

#include "gvx/core/noise.h"
#include "gvx/exec/parallel.h"

namespace gvx::bench {
namespace {

constexpr std::size_t kChunk = 1 << 14;

/// Calls function(i) for every i, many at a time.
template <typename Function>
void for_each(const exec::Device& cpu, std::size_t count, const Function& function) {
  exec::parallel_for(cpu, (count + kChunk - 1) / kChunk, [&](std::size_t chunk) {
    for (std::size_t i = chunk * kChunk; i < std::min((chunk + 1) * kChunk, count); ++i) function(i);
  });
}

/// Vertices at the same place become one, so that no crack opens where vertices move.
void weld(Model& model) {
  const auto before = [&](std::uint32_t a, std::uint32_t b) {
    const Vec3f &p = model.places[a], &q = model.places[b];
    return std::tie(p.x, p.y, p.z, a) < std::tie(q.x, q.y, q.z, b);
  };
  std::vector<std::uint32_t> order(model.places.size()), now(order.size());
  std::iota(order.begin(), order.end(), 0u);
  tbb::parallel_sort(order.begin(), order.end(), before);
  std::vector<Vec3f> places;
  for (const std::uint32_t vertex : order) {
    if (places.empty() || !(places.back() == model.places[vertex])) places.push_back(model.places[vertex]);
    now[vertex] = static_cast<std::uint32_t>(places.size() - 1);
  }
  for (io::Triangle& triangle : model.triangles) {
    for (std::uint32_t& vertex : triangle) vertex = now[vertex];
  }
  model.places = std::move(places);
}

/// The mean of the triangles at each vertex, by their angles there.
void find_normals(const exec::Device& cpu, Model& model) {
  model.normals.assign(model.places.size(), {});
  for (const io::Triangle& triangle : model.triangles) {
    Vec3f corner[3];
    for (std::size_t i = 0; i < 3; ++i) corner[i] = model.places[triangle[i]];
    const Vec3f across = cross(corner[1] - corner[0], corner[2] - corner[0]);
    if (!(length(across) > 0)) continue;
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3f a = corner[(i + 1) % 3] - corner[i], b = corner[(i + 2) % 3] - corner[i];
      const float angle = std::atan2(length(cross(a, b)), dot(a, b));
      Vec3f& normal = model.normals[triangle[i]];
      normal = normal + angle / length(across) * across;
    }
  }
  for_each(cpu, model.normals.size(), [&](std::size_t i) {
    const float size = length(model.normals[i]);
    model.normals[i] = size > 0 ? model.normals[i] / size : Vec3f(0, 0, 1);
  });
}

/// Cuts each triangle into four.
void split(const exec::Device& cpu, Model& model, std::uint32_t seed) {
  find_normals(cpu, model);
  const std::size_t old_vertices = model.places.size(), old_triangles = model.triangles.size();
  const auto edge_of = [](std::uint32_t a, std::uint32_t b) {
    return std::uint64_t{std::min(a, b)} << 32 | std::max(a, b);
  };
  std::vector<std::uint64_t> edges(3 * old_triangles);
  for_each(cpu, old_triangles, [&](std::size_t t) {
    const io::Triangle& triangle = model.triangles[t];
    for (std::size_t i = 0; i < 3; ++i) edges[3 * t + i] = edge_of(triangle[i], triangle[(i + 1) % 3]);
  });
  tbb::parallel_sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  const auto end_of = [&](std::uint64_t edge, int i) {
    return static_cast<std::uint32_t>(i == 0 ? edge >> 32 : edge & 0xffffffffu);
  };
  double sum = 0;
  const auto length_of = [&](std::uint64_t edge) {
    return static_cast<double>(length(model.places[end_of(edge, 1)] - model.places[end_of(edge, 0)]));
  };
  for (const std::uint64_t edge : edges) sum += length_of(edge);
  const double mean = sum / static_cast<double>(edges.size());
  model.places.reserve(old_vertices + edges.size() + 1);
  model.places.resize(old_vertices + edges.size());
  for_each(cpu, edges.size(), [&](std::size_t e) {
    const std::uint32_t a = end_of(edges[e], 0), b = end_of(edges[e], 1);
    const Vec3d middle = 0.5 * Vec3d(model.places[a] + model.places[b]);
    const Vec3d normal(model.normals[a] + model.normals[b]);
    const double size = length(normal);
    // By up to a tenth of the edge, so that short ones make no spikes; waves of three edges.
    const double tenth = 0.1 * length_of(edges[e]);
    const double height = size > 1e-3 ? tenth * perlin(middle / (3 * mean), seed) / size : 0;
    model.places[old_vertices + e] = Vec3f(middle + height * normal);
  });
  std::vector<io::Triangle> finer(4 * old_triangles);
  for_each(cpu, old_triangles, [&](std::size_t t) {
    const io::Triangle& v = model.triangles[t];
    std::uint32_t m[3];
    for (std::size_t i = 0; i < 3; ++i) {
      const auto found = std::lower_bound(edges.begin(), edges.end(), edge_of(v[i], v[(i + 1) % 3]));
      m[i] = static_cast<std::uint32_t>(old_vertices + static_cast<std::size_t>(found - edges.begin()));
    }
    finer[4 * t] = {v[0], m[0], m[2]};
    finer[4 * t + 1] = {m[0], v[1], m[1]};
    finer[4 * t + 2] = {m[2], m[1], v[2]};
    finer[4 * t + 3] = {m[0], m[1], m[2]};
  });
  model.triangles = std::move(finer);
}

/// An octahedron, each edge in `parts`, blown up to a sphere with bumps: 8 * parts * parts triangles.
Model bumpy_sphere(int parts) {
  Model model;
  std::unordered_map<std::uint64_t, std::uint32_t> vertices;
  const FractalNoise bumps{4, 0.5, 2, 0.5, 1};
  const auto vertex = [&](int x, int y, int z) {
    const auto part = [&](int i) { return static_cast<std::uint64_t>(i + parts); };
    const auto [found, is_new] = vertices.try_emplace(part(x) << 40 | part(y) << 20 | part(z),
                                                      static_cast<std::uint32_t>(model.places.size()));
    if (is_new) {
      const Vec3d way = normalize(Vec3d(x, y, z));
      model.places.emplace_back((1 + 0.15 * bumps(way, 1e-6)) * way);
    }
    return found->second;
  };
  for (int octant = 0; octant < 8; ++octant) {
    const int sx = (octant & 1) != 0 ? -1 : 1, sy = (octant & 2) != 0 ? -1 : 1,
              sz = (octant & 4) != 0 ? -1 : 1;
    const bool turned = sx * sy * sz < 0;
    const auto add = [&](std::array<std::array<int, 2>, 3> corners) {
      io::Triangle triangle;
      for (std::size_t i = 0; i < 3; ++i) {
        const auto [x, y] = corners[i];
        triangle[turned ? 2 - i : i] = vertex(sx * x, sy * y, sz * (parts - x - y));
      }
      model.triangles.push_back(triangle);
    };
    for (int y = 0; y < parts; ++y) {
      for (int x = 0; x + y < parts; ++x) {
        add({{{x, y}, {x + 1, y}, {x, y + 1}}});
        if (x + y + 1 < parts) add({{{x + 1, y}, {x + 1, y + 1}, {x, y + 1}}});
      }
    }
  }
  return model;
}

/// A smooth pattern of place.
void color(const exec::Device& cpu, Model& model) {
  const Vec3d size = model.bounds.maximum - model.bounds.minimum;
  const double wave = 4 * 2 * M_PI / max_component(size);
  model.colors.resize(model.places.size());
  for_each(cpu, model.places.size(), [&](std::size_t i) {
    const Vec3d p = wave * (Vec3d(model.places[i]) - model.bounds.minimum);
    model.colors[i] =
        Vec3f(Vec3d(0.6 + 0.3 * std::sin(p.x + 0.5 * p.y), 0.6 + 0.3 * std::sin(p.y + 0.5 * p.z + 2),
                    0.6 + 0.3 * std::sin(p.z + 0.5 * p.x + 4)));
  });
}

}  // namespace

Result<Model> make_model(const exec::Device& cpu, const std::string& path, double triangles) {
  Model model;
  int cuts = 2;
  if (path.empty()) {
    model =
        bumpy_sphere(std::max(1, static_cast<int>(std::lround(std::sqrt(triangles / (8 << (2 * cuts)))))));
  } else {
    auto mesh = io::read_mesh(path);
    if (!mesh.ok()) return mesh.error();
    model.places = std::move(mesh.value().vertices);
    model.triangles = std::move(mesh.value().triangles);
    weld(model);
    const double ratio = triangles / static_cast<double>(model.triangles.size());
    cuts = std::max(0, static_cast<int>(std::lround(0.5 * std::log2(ratio))));
  }
  for (int cut = 0; cut < cuts; ++cut) split(cpu, model, static_cast<std::uint32_t>(100 + cut));
  model.places.reserve(model.places.size() + 1);
  find_normals(cpu, model);
  model.bounds = {Vec3d(INFINITY), Vec3d(-INFINITY)};
  for (const io::Triangle& triangle : model.triangles) {
    for (const std::uint32_t vertex : triangle) {
      for (int axis = 0; axis < 3; ++axis) {
        const double at = static_cast<double>(model.places[vertex][axis]);
        model.bounds.minimum[axis] = std::min(model.bounds.minimum[axis], at);
        model.bounds.maximum[axis] = std::max(model.bounds.maximum[axis], at);
      }
    }
  }
  if (!path.empty()) model.up = io::mesh_up(path, model.bounds).axis;
  color(cpu, model);
  return model;
}

Result<std::unique_ptr<mesh::MeshSpool>> spooled(const Model& model, const std::string& folder,
                                                 std::uint64_t memory_bytes) {
  auto created = mesh::MeshSpool::create(folder, memory_bytes);
  if (!created.ok()) return created.error();
  auto spool = std::move(created).value();
  std::vector<Vec3d> places;
  for (std::size_t first = 0; first < model.places.size(); first += kChunk) {
    const std::size_t count = std::min(kChunk, model.places.size() - first);
    places.clear();
    for (std::size_t i = 0; i < count; ++i) places.emplace_back(model.places[first + i]);
    const Status added = spool->add_vertices(places, std::span(model.colors).subspan(first, count));
    if (!added.ok()) return added.error();
  }
  for (std::size_t first = 0; first < model.triangles.size(); first += kChunk) {
    const std::size_t count = std::min(kChunk, model.triangles.size() - first);
    const Status added = spool->add_triangles(std::span(model.triangles).subspan(first, count));
    if (!added.ok()) return added.error();
  }
  const Status finished = spool->finish();
  if (!finished.ok()) return finished.error();
  return spool;
}

}  // namespace gvx::bench
