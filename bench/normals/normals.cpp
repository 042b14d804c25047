// How true normals are: the gradients that pictures are lit by, of balls, a torus and a gyroid as scanners
// see them, against the normals of the shapes themselves. See bench/normals/run.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <random>
#include <string>
#include <tuple>
#include <vector>

#include "gvx/core/vec.h"
#include "gvx/exec/device.h"
#include "gvx/exec/parallel.h"
#include "gvx/render/reference/sample.h"
#include "gvx/store/pyramid.h"
#include "gvx/store/store_reader.h"
#include "gvx/store/store_writer.h"

namespace gvx::bench {
namespace {

constexpr int kPoints = 6000;
constexpr double kInside = 3476, kOutside = 200;  // of 12 bits
constexpr double kDegrees = 57.29577951308232;

/// A shape in millimetres: below 0 inside, and about a distance.
struct Shape {
  const char* name;
  double edge;  ///< of the cube that it is in the middle of
  std::function<double(Vec3d)> distance;
};

struct Scan {
  Vec3d spacing;
  double noise, blur;  ///< of the contrast; in millimetres
};

Vec3d normal_of(const Shape& shape, Vec3d p) {
  constexpr double kStep = 1e-4;
  Vec3d g;
  for (int axis = 0; axis < 3; ++axis) {
    Vec3d before = p, after = p;
    before[axis] -= kStep;
    after[axis] += kStep;
    g[axis] = shape.distance(after) - shape.distance(before);
  }
  return g / length(g);
}

std::vector<Shape> shapes() {
  const auto ball = [](double radius, double edge) {
    return [=](Vec3d p) { return length(p - Vec3d(edge / 2) - Vec3d(0.137, 0.274, 0.411)) - radius; };
  };
  const auto torus = [](Vec3d p) {
    const Vec3d q = p - Vec3d(64.1, 63.8, 64.3);
    // Tilted, so that no axis is its own.
    const Vec3d r(0.8 * q.x + 0.6 * q.z, q.y, -0.6 * q.x + 0.8 * q.z);
    return std::hypot(std::hypot(r.x, r.y) - 40, r.z) - 14;
  };
  const auto gyroid = [](Vec3d p) {
    const Vec3d q = (2 * M_PI / 48) * p;
    const double f =
        std::sin(q.x) * std::cos(q.y) + std::sin(q.y) * std::cos(q.z) + std::sin(q.z) * std::cos(q.x);
    const Vec3d g(std::cos(q.x) * std::cos(q.y) - std::sin(q.z) * std::sin(q.x),
                  std::cos(q.y) * std::cos(q.z) - std::sin(q.x) * std::sin(q.y),
                  std::cos(q.z) * std::cos(q.x) - std::sin(q.y) * std::sin(q.z));
    return f / (2 * M_PI / 48 * std::max(length(g), 0.5));
  };
  return {{"ball, radius 30", 80, ball(30, 80)},
          {"ball, radius 80", 180, ball(80, 180)},
          {"torus, 40 and 14", 128, torus},
          {"gyroid, period 48", 128, gyroid}};
}

/// Gaussian, along one axis.
void blur(std::vector<float>& voxels, Vec3i d, int axis, double sigma) {
  const int reach = static_cast<int>(std::ceil(4 * sigma));
  std::vector<double> weights;
  double sum = 0;
  for (int i = -reach; i <= reach; ++i) sum += weights.emplace_back(std::exp(-0.5 * i * i / (sigma * sigma)));
  const std::vector<float> from = voxels;
  const std::int64_t strides[3] = {1, d.x, d.x * d.y}, stride = strides[axis];
  exec::parallel_for(exec::Device::cpu(), static_cast<std::size_t>(d.z), [&](std::size_t z) {
    for (std::int64_t i = static_cast<std::int64_t>(z) * strides[2];
         i < static_cast<std::int64_t>(z + 1) * strides[2]; ++i) {
      const std::int64_t at = i / stride % d[axis];
      double value = 0;
      for (int k = -reach; k <= reach; ++k) {
        const std::int64_t held = std::clamp<std::int64_t>(at + k, 0, d[axis] - 1);
        value += weights[static_cast<std::size_t>(k + reach)] *
                 from[static_cast<std::size_t>(i + (held - at) * stride)];
      }
      voxels[static_cast<std::size_t>(i)] = static_cast<float>(value / sum);
    }
  });
}

/// What a scanner makes of a shape: the share of each voxel that is inside, of 4^3 places in it.
std::vector<std::uint16_t> scanned(const Shape& shape, const Scan& scan, Vec3i d) {
  std::vector<float> share(static_cast<std::size_t>(d.x * d.y * d.z));
  exec::parallel_for(exec::Device::cpu(), static_cast<std::size_t>(d.z), [&](std::size_t slice) {
    const auto z = static_cast<std::int64_t>(slice);
    for (std::int64_t i = 0; i < d.x * d.y; ++i) {
      const Vec3d low = scan.spacing * Vec3d(Vec3i(i % d.x, i / d.x, z));
      const double from_surface = shape.distance(low + 0.5 * scan.spacing);
      int inside = 0;
      if (std::abs(from_surface) > 3) {
        inside = from_surface < 0 ? 64 : 0;
      } else {
        for (int k = 0; k < 64; ++k) {
          const Vec3d place = (Vec3d(Vec3i(k % 4, k / 4 % 4, k / 16)) + Vec3d(0.5)) / 4.0;
          inside += shape.distance(low + scan.spacing * place) < 0 ? 1 : 0;
        }
      }
      share[static_cast<std::size_t>(z * d.x * d.y + i)] = static_cast<float>(inside) / 64;
    }
  });
  if (scan.blur > 0) {
    for (int axis = 0; axis < 3; ++axis) blur(share, d, axis, scan.blur / scan.spacing[axis]);
  }
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0, scan.noise > 0 ? scan.noise : 1);
  std::vector<std::uint16_t> voxels;
  for (const float s : share) {
    const double v = kOutside + (kInside - kOutside) * (s + (scan.noise > 0 ? noise(random) : 0));
    voxels.push_back(static_cast<std::uint16_t>(std::clamp(std::round(v), 0.0, 4095.0)));
  }
  return voxels;
}

/// A store's finest bricks, sampled as rays sample them.
template <int M>
class Bricks {
 public:
  Bricks(const std::string& path, const std::vector<std::uint16_t>& voxels, Vec3i d) {
    store::VolumeInfo info;
    info.shape = store::TreeShape::covering(d, 2, M);
    info.format.type = VoxelType::u16;
    info.codec = store::Codec::none;
    auto writer = store::StoreWriter::create(path, info.shape, info.format).value();
    store::PyramidBuilder builder(exec::Device::cpu(), *writer, info);
    GVX_CHECK(builder.push_slices(d.z, std::as_bytes(std::span(voxels))).ok() && builder.finish().ok());
    reader_ = store::StoreReader::open(path).value();
    std::filesystem::remove(path);
  }

  float value(Vec3d voxel) {
    const Vec3i node = node_of(voxel);
    return render::one_lane::sample(texels(node), M, in_node(voxel, node));
  }
  Vec3d gradient(Vec3d voxel) { return gradient_in(node_of(voxel), voxel); }
  Vec3d gradient_in(Vec3i node, Vec3d voxel) {
    return Vec3d(render::one_lane::gradient(texels(node), M, in_node(voxel, node)));
  }
  static Vec3i node_of(Vec3d voxel) {
    return {static_cast<std::int64_t>(voxel.x) / M, static_cast<std::int64_t>(voxel.y) / M,
            static_cast<std::int64_t>(voxel.z) / M};
  }

 private:
  static Vec3f in_node(Vec3d voxel, Vec3i node) { return Vec3f(voxel - double(M) * Vec3d(node)); }
  render::one_lane::PlainTexels<std::uint16_t> texels(Vec3i node) {
    auto& brick = bricks_[{node.x, node.y, node.z}];
    if (brick.empty()) {
      brick.resize(reader_->info().brick_bytes());
      const NodeKey key{reader_->info().shape.levels - 1, static_cast<std::uint64_t>(node.x),
                        static_cast<std::uint64_t>(node.y), static_cast<std::uint64_t>(node.z)};
      GVX_CHECK(reader_->read_brick(key, reader_->node(key).value(), brick).ok());
    }
    return {reinterpret_cast<const std::uint16_t*>(brick.data()), M};
  }

  std::unique_ptr<store::StoreReader> reader_;
  std::map<std::tuple<std::int64_t, std::int64_t, std::int64_t>, std::vector<std::byte>> bricks_;
};

struct Normals {
  Vec3d here, beside;
};
using Gradient = std::function<Vec3d(Vec3d world)>;

double at_share(std::vector<double> numbers, double share) {
  std::sort(numbers.begin(), numbers.end());
  return numbers[static_cast<std::size_t>(share * static_cast<double>(numbers.size() - 1))];
}
double mean(const std::vector<double>& numbers) {
  double sum = 0;
  for (const double n : numbers) sum += n;
  return sum / static_cast<double>(numbers.size());
}

/// Angles to the true normals, and by how much the normals of two points beside each other differ from what
/// they should; both in degrees.
void print_row(const char* name, const std::vector<Normals>& found, const std::vector<Normals>& truth) {
  std::vector<double> angles, grain;
  for (std::size_t i = 0; i < found.size(); ++i) {
    angles.push_back(kDegrees * std::acos(std::clamp(dot(found[i].here, truth[i].here), -1.0, 1.0)));
    grain.push_back(kDegrees * length((found[i].beside - found[i].here) - (truth[i].beside - truth[i].here)));
  }
  std::printf("| %s | %.2f | %.2f | %.2f | %.2f |\n", name, mean(angles), at_share(angles, 0.95), mean(grain),
              at_share(grain, 0.95));
}

/// Written for the peer, read from it: points in voxels of the volume's index space, normals in the world.
void write(const std::string& path, const void* bytes, std::size_t size) {
  std::ofstream(path, std::ios::binary)
      .write(static_cast<const char*>(bytes), static_cast<std::streamsize>(size));
}

void measure(const Shape& shape, const Scan& scan, const std::string& folder, const std::string& peer) {
  const Vec3i d(static_cast<std::int64_t>(shape.edge / scan.spacing.x),
                static_cast<std::int64_t>(shape.edge / scan.spacing.y),
                static_cast<std::int64_t>(shape.edge / scan.spacing.z));
  const std::vector<std::uint16_t> voxels = scanned(shape, scan, d);
  Bricks<16> bricks(folder + "/normals.gvx", voxels, d);
  const float isovalue = static_cast<float>((kInside + kOutside) / 2);

  // Points of the isosurface, and others a quarter of a millimetre beside them.
  std::mt19937 random(3);
  std::uniform_real_distribution<double> anywhere(8, shape.edge - 8), way(-1, 1);
  const auto on_shape = [&](Vec3d p) {
    for (int i = 0; i < 8; ++i) p = p - shape.distance(p) * normal_of(shape, p);
    return p;
  };
  const auto on_isosurface = [&](Vec3d p) {
    const Vec3d n = normal_of(shape, p);
    double inner = -3, outer = 3;
    for (int i = 0; i < 40; ++i) {
      const double middle = (inner + outer) / 2;
      (bricks.value((p + middle * n) / scan.spacing) > isovalue ? inner : outer) = middle;
    }
    return p + inner * n;
  };
  std::vector<Vec3d> points;
  std::vector<Normals> truth;
  while (truth.size() < kPoints) {
    const Vec3d start(anywhere(random), anywhere(random), anywhere(random));
    if (std::abs(shape.distance(start)) > 4) continue;
    const Vec3d p = on_shape(start), n = normal_of(shape, p);
    const Vec3d aside = cross(n, Vec3d(way(random), way(random), way(random)));
    const Vec3d q = on_shape(p + 0.25 / length(aside) * aside);
    const auto inside = [&](Vec3d at) {
      return std::min({at.x, at.y, at.z}) > 8 && std::max({at.x, at.y, at.z}) < shape.edge - 8;
    };
    if (!inside(p) || !inside(q)) continue;
    points.push_back(on_isosurface(p) / scan.spacing);
    points.push_back(on_isosurface(q) / scan.spacing);
    truth.push_back({n, normal_of(shape, q)});
  }

  std::printf(
      "\n%s, voxels 1:1:%g%s\n\n| gradient | angle, mean | 95 %% | grain, mean | 95 %% "
      "|\n|---|---|---|---|---|\n",
      shape.name, scan.spacing.z, scan.noise > 0 ? ", blurred by 0.7 mm, noise of 2 %" : "");
  const auto normals_by = [&](const Gradient& gradient) {
    std::vector<Normals> found;
    for (std::size_t i = 0; i < points.size(); i += 2) {
      const auto unit = [&](Vec3d p) {
        const Vec3d g = -1.0 * (gradient(p) / scan.spacing);
        return g / length(g);
      };
      found.push_back({unit(points[i]), unit(points[i + 1])});
    }
    return found;
  };
  print_row("gvx", normals_by([&](Vec3d p) { return bricks.gradient(p); }), truth);
  const auto differences_of = [&](double reach) {
    return [&bricks, reach](Vec3d p) {
      Vec3d g;
      for (int axis = 0; axis < 3; ++axis) {
        Vec3d before = p, after = p;
        before[axis] -= reach;
        after[axis] += reach;
        g[axis] = static_cast<double>(bricks.value(after) - bricks.value(before));
      }
      return g;
    };
  };
  print_row("differences of half a voxel", normals_by(differences_of(0.5)), truth);
  print_row("differences of one voxel", normals_by(differences_of(1)), truth);
  if (!peer.empty()) {
    const std::string name = folder + "/volume";
    write(name + ".raw", voxels.data(), voxels.size() * sizeof(voxels[0]));
    write(name + ".points", points.data(), points.size() * sizeof(points[0]));
    const std::string command =
        peer + " " + name + " " + std::to_string(d.x) + " " + std::to_string(d.y) + " " + std::to_string(d.z);
    if (std::system(command.c_str()) != 0) std::exit(1);
    std::vector<Vec3d> gradients(points.size());
    std::ifstream(name + ".gradients", std::ios::binary)
        .read(reinterpret_cast<char*>(gradients.data()),
              static_cast<std::streamsize>(gradients.size() * sizeof(gradients[0])));
    std::size_t next = 0;
    print_row("VTK", normals_by([&](Vec3d) { return gradients[next++]; }), truth);
  }

  // Both bricks at a face must tell the same gradient of it.
  double seam = 0, steepest = 0;
  for (std::size_t i = 0; i < points.size(); i += 2) {
    Vec3d p = points[i];
    const int axis = static_cast<int>(i / 2 % 3);
    p[axis] = std::max(std::round(p[axis] / 16), 1.0) * 16;
    const Vec3i after = Bricks<16>::node_of(p);
    Vec3i before = after;
    --before[axis];
    if (static_cast<double>(16 * after[axis]) >= static_cast<double>(d[axis])) continue;
    const Vec3d g = bricks.gradient_in(after, p);
    seam = std::max(seam, length(g - bricks.gradient_in(before, p)));
    steepest = std::max(steepest, length(g));
  }
  std::printf("\nAt faces of bricks gradients differ by at most %.1g of the steepest.\n", seam / steepest);
}

}  // namespace
}  // namespace gvx::bench

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: gvx_bench_normals FOLDER [PEER]\n");
    return 2;
  }
  using gvx::Vec3d;
  for (const auto& shape : gvx::bench::shapes()) {
    for (const double slices : {1.0, 1.6}) {
      for (const bool noisy : {false, true}) {
        const Vec3d spacing(1, 1, slices);
        gvx::bench::measure(shape, {spacing, noisy ? 0.02 : 0, noisy ? 0.7 : 0}, argv[1],
                            argc > 2 ? argv[2] : "");
      }
    }
  }
  return 0;
}
