// Opens a store, prints what is in it and the values along a line, and renders it.
//
//     gvx build VOLUME -o STORE.gvx
//     open_store STORE.gvx OUT.png

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <memory>
#include <vector>

#include <gvx/engine/engine.h>
#include <gvx/io/image.h>
#include <gvx/produce/store_producer.h>
#include <gvx/scene/transfer_presets.h>
#include <gvx/store/store_reader.h>

// The value of a voxel, in the units of the file that the store was built from. A store keeps voxels in
// bricks of m^3. Each brick has a border: copies of the voxels around it.
static gvx::Result<double> value_at(const gvx::store::StoreReader& store, gvx::Vec3i voxel) {
  const gvx::store::VolumeInfo& info = store.info();
  const std::int64_t m = info.shape.m, border = gvx::kBrickBorder, edge = m + 2 * border;
  // The brick of the finest level that holds the voxel. Its key counts bricks along each axis.
  const auto brick_along = [&](int axis) { return static_cast<std::uint64_t>(voxel[axis] / m); };
  const gvx::NodeKey key{info.shape.levels - 1, brick_along(0), brick_along(1), brick_along(2)};
  std::vector<std::byte> brick(info.brick_bytes());
  GVX_ASSIGN(const auto record, store.node(key));
  GVX_TRY(store.read_brick(key, record, brick));
  const auto texel = voxel.x % m + border + edge * (voxel.y % m + border + edge * (voxel.z % m + border));
  return gvx::with_voxel_type(info.format.type, [&](auto stored) -> gvx::Result<double> {
    std::memcpy(&stored, &brick[static_cast<std::size_t>(texel) * sizeof(stored)], sizeof(stored));
    return info.scale * static_cast<double>(stored) + info.offset;
  });
}

static gvx::Status run(const char* path, const char* picture) {
  GVX_ASSIGN(auto store, gvx::store::StoreReader::open(path));
  const gvx::store::VolumeInfo& info = store->info();
  const gvx::Vec3i size = info.shape.dimensions;
  std::printf("%lld x %lld x %lld voxels of %u x %s\n", static_cast<long long>(size.x),
              static_cast<long long>(size.y), static_cast<long long>(size.z), info.format.planes,
              gvx::voxel_name(info.format.type));
  for (int i = 0; i < 5; ++i) {
    const gvx::Vec3i voxel{i * (size.x - 1) / 4, size.y / 2, size.z / 2};
    GVX_ASSIGN(const double value, value_at(*store, voxel));
    std::printf("voxel (%lld, %lld, %lld): %g\n", static_cast<long long>(voxel.x),
                static_cast<long long>(voxel.y), static_cast<long long>(voxel.z), value);
  }

  // A producer hands bricks to the engine. This one reads them from the store.
  const auto volume = std::make_shared<gvx::produce::StoreProducer>(std::move(store));
  const gvx::produce::TreeDescription& tree = volume->description();
  GVX_ASSIGN(const auto engine, gvx::engine::Engine::create(gvx::exec::Device::cpu(), volume, {}));
  gvx::render::View view;
  view.width = view.height = 512;
  view.camera = gvx::scene::frame_box(tree.extent, tree.tree_to_world, tree.anatomical, 1);
  // A transfer function for each channel, chosen by its values. Colours and labels need none.
  const bool scalar = tree.format.content == gvx::VoxelContent::scalar;
  for (std::uint32_t channel = 0; scalar && channel < tree.format.channels(); ++channel) {
    auto statistics = gvx::scene::physical_statistics(tree.ranges.channel[channel], tree.histograms[channel],
                                                      tree.scale, tree.offset);
    statistics.anatomical = tree.anatomical;
    GVX_ASSIGN(auto function, gvx::scene::preset(gvx::scene::suggest_preset(statistics), statistics));
    view.functions.push_back(std::move(function));
  }
  GVX_TRY(engine->look(view));
  GVX_TRY(engine->render_exact());
  return gvx::io::write_png(picture, view.width, view.height, engine->picture().to_8_bit());
}

int main(int argc, char** argv) {
  if (argc != 3) return std::fprintf(stderr, "usage: open_store STORE.gvx OUT.png\n"), 2;
  const gvx::Status status = run(argv[1], argv[2]);
  if (!status.ok()) std::fprintf(stderr, "%s\n", status.error().message.c_str());
  return status.ok() ? 0 : 1;
}
