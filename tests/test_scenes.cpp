#include "test_scenes.h"

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include <gtest/gtest.h>

#include "gvx/io/store_build.h"
#include "gvx/io/volume_reader.h"
#include "gvx/produce/store_producer.h"
#include "gvx/scene/framing.h"
#include "gvx/store/pyramid.h"
#include "gvx/store/store_reader.h"

namespace gvx::tests {
namespace {

/// A view of the whole box from the front, a little above and from the left. The tests' own, so that they
/// look at the same pictures however scenes are framed for people.
scene::Camera camera_of(const Vec3d& size, const Affine3& to_world, double aspect) {
  scene::Camera camera;
  const Vec3d to_eye = normalize(Vec3d{-0.45, -1, 0.35});
  camera.up = {0, 0, 1};
  camera.target = to_world.point(0.5 * size);
  const Vec3d right = normalize(cross(-to_eye, camera.up)), up = cross(right, -to_eye);
  const double tangent = std::tan(camera.fov_degrees / 2 * M_PI / 180) * 0.95;
  double distance = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3d p{corner & 1 ? size.x : 0, corner & 2 ? size.y : 0, corner & 4 ? size.z : 0};
    const Vec3d d = to_world.point(p) - camera.target;
    const double across = std::max(std::abs(dot(d, up)), std::abs(dot(d, right)) / aspect);
    distance = std::max(distance, dot(d, to_eye) + across / tangent);
  }
  camera.eye = camera.target + distance * to_eye;
  return camera;
}

render::View framed_view(const ReferenceVolume& volume, const scene::TransferFunction& function) {
  render::View view;
  view.width = 160;
  view.height = 120;
  view.functions = {function};
  view.camera = camera_of(Vec3d(volume.dimensions), volume.voxel_to_world, 4.0 / 3);
  view.background = {0.1f, 0.2f, 0.3f};
  return view;
}

scene::TransferFunction soft_function() {
  return {{{0, {0.1, 0.2, 0.9}}, {0.5, {0.9, 0.6, 0.2}}, {1, {1, 1, 0.9}}},
          {{0.3, 0}, {0.5, 0.08}, {0.75, 0.3}, {1, 0.5}},
          0};
}

}  // namespace

std::shared_ptr<const produce::Producer> TestScene::open() const {
  return std::make_shared<produce::StoreProducer>(store::StoreReader::open(store_path).value());
}

TestScene analytic_scene(const std::string& name, const std::function<double(Vec3d)>& field, Vec3i dimensions,
                         Vec3d spacing, std::uint32_t n, std::uint32_t m) {
  auto voxels = std::make_shared<std::vector<float>>();
  for (std::int64_t z = 0; z < dimensions.z; ++z) {
    for (std::int64_t y = 0; y < dimensions.y; ++y) {
      for (std::int64_t x = 0; x < dimensions.x; ++x) {
        voxels->push_back(
            static_cast<float>(field((Vec3d(Vec3i(x, y, z)) + Vec3d(0.5)) / Vec3d(dimensions))));
      }
    }
  }
  TestScene scene;
  scene.volume.dimensions = dimensions;
  scene.volume.voxel_to_world = scaling(spacing);
  scene.volume.voxel = [voxels, dimensions](std::int64_t x, std::int64_t y, std::int64_t z) {
    return double((*voxels)[static_cast<std::size_t>((z * dimensions.y + y) * dimensions.x + x)]);
  };
  scene.store_path = testing::TempDir() + "gvx_scene_" + name + ".gvx";
  store::VolumeInfo info;
  info.shape = store::TreeShape::covering(dimensions, n, m);
  info.format.type = VoxelType::f32;
  info.voxel_to_world = scene.volume.voxel_to_world;
  const auto writer = store::StoreWriter::create(scene.store_path, info.shape, info.format).value();
  store::PyramidBuilder pyramid(exec::Device::cpu(), *writer, info);
  GVX_CHECK(pyramid.push_slices(dimensions.z, std::as_bytes(std::span(*voxels))).ok());
  GVX_CHECK(pyramid.finish().ok());
  scene.view = framed_view(scene.volume, soft_function());
  return scene;
}

TestScene planar_scene(const std::string& name, VoxelFormat format, const std::vector<Field>& planes,
                       Vec3i dimensions, std::uint32_t n, std::uint32_t m, double scale, double offset) {
  GVX_CHECK(planes.size() == format.planes && format.valid());
  auto numbers = std::make_shared<std::vector<double>>();
  std::vector<std::byte> bytes;
  with_voxel_type(format.type, [&](auto number) {
    for (std::int64_t z = 0; z < dimensions.z; ++z) {
      for (std::int64_t y = 0; y < dimensions.y; ++y) {
        for (std::int64_t x = 0; x < dimensions.x; ++x) {
          const Vec3d p = (Vec3d(Vec3i(x, y, z)) + Vec3d(0.5)) / Vec3d(dimensions);
          for (const Field& plane : planes) {
            number = static_cast<decltype(number)>(plane(p));
            numbers->push_back(scale * static_cast<double>(number) + offset);
            bytes.resize(bytes.size() + sizeof(number));
            std::memcpy(&bytes[bytes.size() - sizeof(number)], &number, sizeof(number));
          }
        }
      }
    }
  });
  TestScene scene;
  scene.volume.dimensions = dimensions;
  scene.volume.content = format.content;
  const auto count = static_cast<std::int64_t>(format.planes);
  for (std::int64_t c = 0; c < count; ++c) {
    const auto read = [numbers, dimensions, count, c](std::int64_t x, std::int64_t y, std::int64_t z) {
      const std::int64_t voxel = (z * dimensions.y + y) * dimensions.x + x;
      return (*numbers)[static_cast<std::size_t>(voxel * count + c)];
    };
    if (c == 0) {
      scene.volume.voxel = read;
    } else {
      scene.volume.more_planes.emplace_back(read);
    }
  }
  scene.store_path = testing::TempDir() + "gvx_scene_" + name + ".gvx";
  store::VolumeInfo info;
  info.shape = store::TreeShape::covering(dimensions, n, m);
  info.format = format;
  info.scale = scale;
  info.offset = offset;
  const auto writer = store::StoreWriter::create(scene.store_path, info.shape, info.format).value();
  store::PyramidBuilder pyramid(exec::Device::cpu(), *writer, info);
  GVX_CHECK(pyramid.push_slices(dimensions.z, bytes).ok());
  GVX_CHECK(pyramid.finish().ok());
  scene.view = framed_view(scene.volume, soft_function());
  return scene;
}

double ball(Vec3d p) {
  const double r = length(p - Vec3d(0.5)) * 2.2;
  const double dent = std::exp(-30 * dot(p - Vec3d(0.3, 0.2, 0.7), p - Vec3d(0.3, 0.2, 0.7)));
  return std::clamp(std::exp(-2 * r * r) - 0.4 * dent, 0.0, 1.0);
}

double waves(Vec3d p) {
  return 0.5 + 0.25 * std::sin(37 * p.x + 11 * p.y) * std::cos(29 * p.z) + 0.25 * std::sin(23 * (p.y + p.z));
}

std::string test_data(const std::string& file) {
  const char* folder = std::getenv("GVX_TEST_DATA");
  if (folder == nullptr) return {};
  const std::string path = std::string(folder) + "/" + file;
  return std::filesystem::exists(path) ? path : std::string();
}

Result<TestScene> file_scene(const std::string& file, std::uint32_t m) {
  GVX_ASSIGN(auto reader, io::open_volume(test_data(file), {}));
  const io::VolumeDescription d = reader->description();
  auto samples = std::make_shared<std::vector<std::byte>>(io::volume_bytes(d));
  GVX_TRY(reader->read_slices(d.dimensions.z, *samples));
  TestScene scene;
  scene.volume.dimensions = d.dimensions;
  scene.volume.voxel_to_world = d.voxel_to_world;
  scene.volume.voxel = [samples, d](std::int64_t x, std::int64_t y, std::int64_t z) {
    const auto i = static_cast<std::size_t>((z * d.dimensions.y + y) * d.dimensions.x + x);
    return io::with_sample_type(d.type, [&](auto v) {
      std::memcpy(&v, samples->data() + i * sizeof(v), sizeof(v));
      return d.scale * static_cast<double>(v) + d.offset;
    });
  };
  scene.store_path = testing::TempDir() + "gvx_file_scene_" + std::to_string(m) + ".gvx";
  GVX_TRY(reader->rewind());
  io::StoreBuildOptions options;
  options.m = m;
  GVX_ASSIGN(const auto report, io::build_store(exec::Device::cpu(), *reader, scene.store_path, options, {}));
  (void)report;
  const produce::TreeDescription tree = scene.open()->description();
  const double low = tree.scale * tree.ranges.channel[0].minimum + tree.offset,
               high = tree.scale * tree.ranges.channel[0].maximum + tree.offset;
  const auto at = [&](double share) { return low + share * (high - low); };
  scene.view = framed_view(scene.volume,
                           {{{at(0.1), {0.6, 0.3, 0.2}}, {at(0.4), {0.9, 0.8, 0.6}}, {at(0.9), {1, 1, 1}}},
                            {{at(0.15), 0}, {at(0.3), 0.1}, {at(0.6), 0.6}},
                            0});
  return scene;
}

render::Picture render_exact(const TestScene& scene, const exec::Device& device,
                             const engine::EngineOptions& options, engine::Statistics* statistics) {
  const auto engine = engine::Engine::create(device, scene.open(), options).value();
  GVX_CHECK(engine->look(scene.view).ok());
  const Status status = engine->render_exact();
  if (!status.ok()) std::fprintf(stderr, "%s\n", status.error().message.c_str());
  GVX_CHECK(status.ok());
  engine->residency().check_invariants();
  if (statistics != nullptr) *statistics = engine->statistics();
  return engine->picture();
}

}  // namespace gvx::tests
