#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <numbers>

#include "gvx/produce/store_producer.h"
#include "gvx/scene/framing.h"
#include "gvx/store/store_reader.h"
#include "scenes.h"

namespace gvx::bench {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;
// Pixels along an edge of the sketch that a reference picture is known by.
constexpr std::uint32_t kSketch = 12;

double distance(const scene::Camera& camera) {
  return length(camera.target - camera.eye);
}

render::View base_view(const Volume& volume, const scene::TransferFunction& function) {
  render::View view;
  view.functions = {function};
  view.camera = scene::frame_box(volume.dense->extent(), volume.dense->voxel_to_world(),
                                 volume.dense->anatomical(), 1, 0.95);
  return view;
}

/// As many pixels, each this wide at the target.
void zoom(render::View& view, std::uint32_t pixels, double pixel_world) {
  view.width = view.height = pixels;
  view.camera.fov_degrees = 2 * std::atan(pixels * pixel_world / 2 / distance(view.camera)) * kDegrees;
}

/// How much the brightness of a picture varies.
double contrast(const render::Picture& picture) {
  double sum = 0, squares = 0, pixels = double(picture.width) * picture.height;
  for (std::size_t i = 0; i < picture.rgba.size(); i += 4) {
    const double luma = double(picture.rgba[i] + picture.rgba[i + 1] + picture.rgba[i + 2]) / 3;
    sum += luma;
    squares += luma * luma;
  }
  return squares / pixels - sum / pixels * sum / pixels;
}

/// Of the view and of a small picture of it, so that a reference picture is made anew when voxels, functions,
/// lighting or the reference renderer change.
std::uint64_t fingerprint(const BruteForce& brute_force, const render::View& view,
                          std::uint32_t rays_per_axis) {
  std::string text = scene::to_text(view.camera) + ' ' + std::to_string(view.width) + ' ' +
                     std::to_string(view.height) + ' ' + std::to_string(rays_per_axis);
  render::View sketch = view;
  sketch.width = sketch.height = kSketch;
  const render::Picture picture = brute_force.render(sketch, 1).picture;
  text.append(reinterpret_cast<const char*>(picture.rgba.data()), picture.rgba.size() * sizeof(float));
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  return hash;
}

}  // namespace

NamedView near_view(const Volume& volume, const scene::TransferFunction& function) {
  constexpr std::uint32_t kPixels = 80, kSketchPixels = 16;
  constexpr int kCandidates = 7;
  const BruteForce brute_force(*volume.dense, function);
  const render::View whole = base_view(volume, function);
  const scene::CameraView camera = scene::make_view(whole.camera, kCandidates, kCandidates).value();
  const double pixel = volume.dense->spacing() / 4;
  render::View best = whole;
  double most = -1;
  for (int candidate = 0; candidate < kCandidates * kCandidates; ++candidate) {
    const Ray ray = camera.pixel_ray(candidate % kCandidates, candidate / kCandidates);
    const auto t = brute_force.depth(ray, 0.3);
    if (!t) continue;
    render::View view = whole;
    view.camera.target = ray.at(*t);
    zoom(view, kSketchPixels, pixel * kPixels / kSketchPixels);
    const double found = contrast(brute_force.render(view, 1).picture);
    if (found <= most) continue;
    most = found;
    best = view;
  }
  zoom(best, kPixels, pixel);
  return {"near", 4, best};
}

NamedView middle_view(const Volume& volume, const scene::TransferFunction& function) {
  render::View view = base_view(volume, function);
  zoom(view, 120, volume.dense->spacing());
  return {"middle", 4, view};
}

NamedView framed_view(const Volume& volume, const scene::TransferFunction& function,
                      double voxels_per_pixel) {
  render::View view = base_view(volume, function);
  const double across = 2 * distance(view.camera) * std::tan(view.camera.fov_degrees / 2 / kDegrees);
  view.width = view.height =
      static_cast<std::uint32_t>(std::lround(across / volume.dense->spacing() / voxels_per_pixel));
  const bool farther = voxels_per_pixel > 4;
  return {farther ? "farther" : "far", farther ? 8u : 6u, view};
}

Reference reference_picture(const std::string& name, const BruteForce& brute_force, const render::View& view,
                            std::uint32_t rays_per_axis, const Folders& folders) {
  char hash[17];
  std::snprintf(hash, sizeof(hash), "%016llx",
                static_cast<unsigned long long>(fingerprint(brute_force, view, rays_per_axis)));
  const std::string path = folders.cache + "/" + name + "-" + hash + ".f32";
  const render::Picture empty{view.width, view.height,
                              std::vector<float>(std::size_t(view.width) * view.height * 4)};
  Reference reference{empty, {empty, empty}};
  const auto parts = {&reference.picture, &reference.half[0], &reference.half[1]};
  std::ifstream in(path, std::ios::binary);
  bool found = in.good() && !folders.fresh;
  for (render::Picture* part : parts) {
    const auto bytes = static_cast<std::streamsize>(part->rgba.size() * sizeof(float));
    found = found && in.read(reinterpret_cast<char*>(part->rgba.data()), bytes).good();
  }
  if (found) return reference;
  reference = brute_force.render(view, rays_per_axis);
  std::ofstream out(path, std::ios::binary);
  for (const render::Picture* part : parts) {
    out.write(reinterpret_cast<const char*>(part->rgba.data()),
              static_cast<std::streamsize>(part->rgba.size() * sizeof(float)));
  }
  return reference;
}

std::unique_ptr<engine::Engine> open_engine(const Volume& volume) {
  auto producer =
      std::make_shared<produce::StoreProducer>(store::StoreReader::open(volume.store_path).value());
  return engine::Engine::create(exec::Device::cpu(), std::move(producer), {2ull << 30, {}}).value();
}

EngineRun render_exact(engine::Engine& engine, const render::View& view, bool timed) {
  const auto render = [&engine](const render::View& v) {
    Status status = engine.look(v);
    if (status.ok()) status = engine.render_exact();
    if (!status.ok()) std::fprintf(stderr, "%s\n", status.error().message.c_str());
    GVX_CHECK(status.ok());
  };
  if (timed) {
    render::View first = view;
    first.antialias = 1;
    first.background.x += 0.5f;
    render(first);
  }
  render(view);
  return {engine.picture(), engine.statistics().frame_milliseconds, engine.statistics().samples};
}

}  // namespace gvx::bench
