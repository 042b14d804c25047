#include <cmath>
#include <functional>
#include <numbers>
#include <span>

#include "gvx/io/store_build.h"
#include "gvx/io/volume_reader.h"
#include "gvx/scene/transfer_presets.h"
#include "gvx/store/pyramid.h"
#include "gvx/store/store_reader.h"
#include "scenes.h"

namespace gvx::bench {
namespace {

constexpr double kPi = std::numbers::pi;

/// Four periods along an axis, values 0 to 1.
double gyroid(Vec3d p) {
  const Vec3d q = 8 * kPi * p;
  const double sum =
      std::sin(q.x) * std::cos(q.y) + std::sin(q.y) * std::cos(q.z) + std::sin(q.z) * std::cos(q.x);
  return 0.5 + sum / 3;
}

/// Marschner and Lobb, "An evaluation of reconstruction filters for volume rendering", 1994: f_M = 6, alpha =
/// 0.25.
double marschner_lobb(Vec3d p) {
  const Vec3d q = 2.0 * p - Vec3d(1);
  const double rings = std::cos(12 * kPi * std::cos(kPi / 2 * std::hypot(q.x, q.y)));
  return (1 - std::sin(kPi / 2 * q.z) + 0.25 * (1 + rings)) / 2.5;
}

Status build_field(const std::string& path, const std::function<double(Vec3d)>& field, std::int64_t edge,
                   std::uint32_t m) {
  store::VolumeInfo info;
  info.shape = store::TreeShape::covering(Vec3i(edge), 2, m);
  info.format.type = VoxelType::f32;
  GVX_ASSIGN(const auto writer, store::StoreWriter::create(path, info.shape, info.format));
  store::PyramidBuilder pyramid(exec::Device::cpu(), *writer, info);
  std::vector<float> slice(static_cast<std::size_t>(edge * edge));
  for (std::int64_t z = 0; z < edge; ++z) {
    for (std::int64_t i = 0; i < edge * edge; ++i) {
      const Vec3d centre = (Vec3d(Vec3i(i % edge, i / edge, z)) + Vec3d(0.5)) / double(edge);
      slice[static_cast<std::size_t>(i)] = static_cast<float>(field(centre));
    }
    GVX_TRY(pyramid.push_slices(1, std::as_bytes(std::span(slice))));
  }
  return pyramid.finish();
}

Status build_file(const std::string& path, const std::string& file, const io::RawOptions& raw,
                  std::uint32_t m) {
  GVX_ASSIGN(const auto reader, io::open_volume(file, raw));
  io::StoreBuildOptions options;
  options.m = m;
  GVX_ASSIGN(const auto report, io::build_store(exec::Device::cpu(), *reader, path, options, {}));
  (void)report;
  return {};
}

Status build(const std::string& name, const std::string& path, std::uint32_t m, const Folders& folders) {
  if (name == "gyroid") return build_field(path, gyroid, 192, m);
  if (name == "marschner-lobb") return build_field(path, marschner_lobb, 128, m);
  if (name == "foam") {
    io::RawOptions raw;
    raw.dimensions = Vec3i(256);
    raw.type = io::SampleType::u8;
    return build_file(path, folders.cache + "/foam.raw", raw, m);
  }
  if (name == "head") return build_file(path, folders.root + "/out/head.nhdr", {}, m);
  if (folders.data.empty()) return Error{name + ": GVX_TEST_DATA is not set"};
  const std::string volumes = folders.data + "/volumes/";
  if (name == "bonsai") return build_file(path, volumes + "nifti/osv_bonsai.nii.gz", {}, m);
  if (name == "engine") return build_file(path, volumes + "nifti/osv_engine.nii.gz", {}, m);
  if (name == "mni152") {
    return build_file(path, volumes + "niivue_formats/MNI152_2009_template.nii.gz", {}, m);
  }
  return Error{name + ": no such volume"};
}

}  // namespace

std::vector<SceneName> scene_names() {
  return {{"head", "ct-bone"},  {"head", "ct-skin"},       {"head", "ct-tissue"}, {"bonsai", "gray"},
          {"engine", "gray"},   {"mni152", "gray"},        {"foam", "walls"},     {"foam", "haze"},
          {"gyroid", "layers"}, {"marschner-lobb", "edge"}};
}

Result<Volume> open_volume(const std::string& name, std::uint32_t m, const Folders& folders) {
  Volume volume;
  volume.name = name;
  volume.store_path = folders.cache + "/" + name + "-" + std::to_string(m) + ".gvx";
  GVX_TRY(build(name, volume.store_path, m, folders));
  GVX_ASSIGN(auto dense, DenseVolume::load(volume.store_path));
  volume.dense = std::make_shared<const DenseVolume>(std::move(dense));
  GVX_ASSIGN(const auto reader, store::StoreReader::open(volume.store_path));
  const store::VolumeInfo& info = reader->info();
  volume.statistics =
      scene::physical_statistics(info.ranges.channel[0], info.histograms[0], info.scale, info.offset);
  return volume;
}

Result<scene::TransferFunction> function_of(const std::string& name, const Volume& volume) {
  if (name == "walls") {
    return scene::TransferFunction{
        {{60, {0.5, 0.35, 0.3}}, {150, {0.9, 0.8, 0.6}}, {250, {1, 1, 1}}}, {{80, 0}, {160, 0.9}}, 0};
  }
  if (name == "haze") {
    return scene::TransferFunction{
        {{20, {0.2, 0.4, 0.9}}, {120, {0.9, 0.5, 0.2}}, {250, {1, 1, 0.8}}}, {{20, 0}, {250, 0.06}}, 0};
  }
  if (name == "layers") {
    return scene::TransferFunction{{{0.2, {0.1, 0.3, 0.9}}, {0.5, {0.9, 0.6, 0.2}}, {0.9, {1, 1, 0.9}}},
                                   {{0.25, 0}, {0.3, 0.03}, {0.35, 0}, {0.7, 0}, {0.8, 0.2}, {0.9, 0.4}},
                                   0};
  }
  if (name == "edge") {
    return scene::TransferFunction{
        {{0.3, {0.8, 0.7, 0.5}}, {0.7, {0.95, 0.9, 0.8}}}, {{0.48, 0}, {0.52, 0.9}}, 0};
  }
  return scene::preset(name, volume.statistics);
}

}  // namespace gvx::bench
