// How fast and how right are surfaces drawn, beside Embree? Of a mesh cut into ever more triangles, and of
// each view: milliseconds of Embree, of what the renderer chooses (hybrid), and of one technique alone;
// bytes; and what differs from Embree's picture. All is in memory. Medians of several, by turns. Prints
// markdown tables and writes JSON.
//
//     gvx_bench_surface OUT.json [--mesh FILE] [--triangles MILLIONS,...] [--threads N] [--repeats N]
//                       [--size WIDTHxHEIGHT] [--only VIEW] [--method NAME] [--scratch FOLDER]
//
// Without a mesh file it is a bumpy sphere. A method's time is that of a whole picture, in memory
// that is there. Embree's hits are shaded one by one, the renderer's in vectors.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "cameras.h"
#include "differences.h"
#include "embree_peer.h"
#include "gvx/mesh/surface_store.h"
#include "gvx/surface/draw/surface_drawing.h"
#include "gvx/surface/draw/surface_test_support.h"
#include "models.h"

namespace gvx::bench {
namespace {

using Clock = std::chrono::steady_clock;

struct Request {
  std::string out, mesh;
  std::string only, method;  ///< a view, a method; empty: all
  std::string scratch = std::filesystem::temp_directory_path().string();
  std::vector<double> millions = {1};
  int threads = 2, repeats = 5;
  std::uint32_t width = 1920, height = 1080;
};

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

template <typename T>
T checked(Result<T> result) {
  if (!result.ok()) {
    std::fprintf(stderr, "%s\n", result.error().message.c_str());
    std::exit(1);
  }
  return std::move(result).value();
}

/// How the renderer is told to draw.
struct Method {
  const char* name;
  std::optional<surface::Technique> only;
};
const Method kMethods[] = {{"hybrid", {}},
                           {"rasterise", surface::Technique::rasterise},
                           {"cast", surface::Technique::cast},
                           {"splat", surface::Technique::splat}};

void draw(surface::SurfaceDrawing& drawing, const surface::SurfaceView& view,
          const surface::SurfaceInstance& instance) {
  drawing.see(view, std::span(&instance, 1));
  constexpr int kMostRounds = 1000;
  for (int round = 0; !drawing.complete(); ++round) {
    GVX_CHECK(round < kMostRounds);
    (void)drawing.advance();
  }
}

surface::SurfaceView view_of(const Request& request, const scene::Camera& camera) {
  surface::SurfaceView view;
  view.width = request.width;
  view.height = request.height;
  view.camera = checked(scene::make_view(camera, view.width, view.height));
  view.lighting = scene::place_lights({}, view.camera.forward, view.camera.right, view.camera.up);
  return view;
}

/// The place on the surface that is seen nearest to the middle of the picture.
Vec3d place_in_middle(const surface::SurfaceView& view, const surface::SurfaceFilmView& film) {
  double least = INFINITY;
  Vec3d place;
  for (std::uint32_t y = 0; y < film.height; ++y) {
    for (std::uint32_t x = 0; x < film.width; ++x) {
      const surface::SurfacePixel& pixel = film.at(x, y);
      const double far = std::hypot(x - 0.5 * film.width, y - 0.5 * film.height);
      if (!pixel.seen() || far >= least) continue;
      least = far;
      const Ray ray = view.camera.pixel_ray(x, y);
      place = ray.at(double(pixel.place) / dot(ray.direction, view.camera.forward));
    }
  }
  return place;
}

/// Triangles whose middles are in the picture, before or behind others.
std::uint64_t triangles_in_view(const Model& model, const surface::SurfaceView& view) {
  const surface::FilmPlane film(view.camera, view.width, view.height);
  const Affine3 to_camera = surface::world_to_camera(view.camera);
  std::uint64_t count = 0;
  for (const io::Triangle& triangle : model.triangles) {
    const Vec3d middle = to_camera.point(
        Vec3d(model.places[triangle[0]] + model.places[triangle[1]] + model.places[triangle[2]]) / 3.0);
    if (!(middle.z > 0)) continue;
    const double x = film.x_of(middle), y = film.y_of(middle);
    count += x > -0.5 && y > -0.5 && x < view.width - 0.5 && y < view.height - 0.5 ? 1 : 0;
  }
  return count;
}

/// A model as both sides hold it.
struct Scene {
  Model model;
  std::unique_ptr<EmbreePeer> embree;
  std::unique_ptr<surface::WholeSurface> whole;
  double cell_world = 0;
  nlohmann::json figures;
};

void make_scene(const Request& request, const exec::Device& cpu, double millions, Scene& scene) {
  scene.model = checked(make_model(cpu, request.mesh, 1e6 * millions));
  const std::string path = request.scratch + "/bench-surface.gvx";
  constexpr std::uint64_t kMemory = 1ull << 30;
  const auto start = Clock::now();
  const auto spool = checked(spooled(scene.model, request.scratch, kMemory));
  const double spool_seconds = seconds_since(start);
  mesh::SurfaceStoreOptions options;
  options.up = scene.model.up;
  options.memory_bytes = kMemory;
  options.source = request.mesh;
  const mesh::SurfaceStoreReport report = checked(mesh::build_surface_store(*spool, path, options));
  const double seconds = seconds_since(start);
  const auto reader = checked(surface::SurfaceReader::open(path));
  scene.whole = std::make_unique<surface::WholeSurface>(*reader);
  std::filesystem::remove(path);
  scene.cell_world = length(scene.whole->info().cells_to_world.column[0]);
  const double triangles = static_cast<double>(spool->summary().triangles);
  scene.figures = {{"millions_asked", millions},
                   {"triangles", spool->summary().triangles},
                   {"levels", report.levels},
                   {"bricks", report.bricks},
                   {"samples", report.samples},
                   {"cell_world", scene.cell_world},
                   {"store_bytes", report.bytes_written},
                   {"bytes_a_triangle", static_cast<double>(report.bytes_written) / triangles},
                   {"build_seconds", seconds},
                   {"build_spool_seconds", spool_seconds},
                   {"build_triangles_a_second", triangles / seconds},
                   {"mesh_bytes", scene.model.bytes()}};
  scene.embree = EmbreePeer::create(cpu, scene.model);
  if (scene.embree == nullptr) return;
  scene.figures["embree"] = {{"build_seconds", scene.embree->build_seconds()},
                             {"bytes", scene.embree->bytes()}};
}

nlohmann::json measure_view(const Request& request, const exec::Device& cpu, Scene& scene, const char* name,
                            const surface::SurfaceView& view) {
  const surface::SurfaceInstance instance = scene.whole->instance();
  nlohmann::json figures = {{"name", name}};
  std::map<std::string, std::vector<double>> times;
  // Of all pictures but the first the memory is there.
  std::vector<PeerPixel> reference(std::size_t{request.width} * request.height);
  surface::SurfaceDrawing drawing(cpu, view, std::span(&instance, 1));
  draw(drawing, view, instance);
  for (int repeat = 0; repeat < request.repeats; ++repeat) {
    if (scene.embree != nullptr) {
      const auto start = Clock::now();
      scene.embree->draw(view, reference);
      times["embree"].push_back(1e3 * seconds_since(start));
    }
    for (const Method& method : kMethods) {
      if (!request.method.empty() && request.method != method.name) continue;
      surface::SurfaceView of_method = view;
      of_method.only = method.only;
      const auto start = Clock::now();
      draw(drawing, of_method, instance);
      times[method.name].push_back(1e3 * seconds_since(start));
      if (repeat + 1 < request.repeats) continue;
      const surface::SurfaceCounts& counts = drawing.counts();
      nlohmann::json& of = figures["methods"][method.name];
      of = {{"cast_bricks", counts.bricks[0]},
            {"splatted_bricks", counts.bricks[1]},
            {"rasterised_bricks", counts.bricks[2]},
            {"hidden_bricks", counts.hidden},
            {"samples", counts.samples},
            {"triangles", counts.triangles},
            {"bytes", counts.bytes}};
      if (!reference.empty())
        of["against_embree"] = to_json(differences(drawing.film(), reference, scene.cell_world));
      if (method.only) continue;
      std::uint64_t covered = 0;
      const surface::SurfaceFilmView film = drawing.film();
      for (std::uint32_t y = 0; y < film.height; ++y) {
        for (std::uint32_t x = 0; x < film.width; ++x) covered += film.at(x, y).seen() ? 1 : 0;
      }
      const std::uint64_t triangles = triangles_in_view(scene.model, view);
      figures["pixels_covered"] = covered;
      figures["triangles_in_view"] = triangles;
      figures["triangles_a_pixel"] =
          static_cast<double>(triangles) / std::max(1.0, static_cast<double>(covered));
    }
  }
  for (const auto& [method, of_method] : times) figures["milliseconds"][method] = median(of_method);
  const nlohmann::json ms = figures["milliseconds"];
  const auto over_hybrid = [&](const char* method) {
    if (!ms.contains(method) || !ms.contains("hybrid")) return;
    figures[std::string(method) + "_over_hybrid"] = ms[method].get<double>() / ms["hybrid"].get<double>();
  };
  over_hybrid("embree");
  over_hybrid("rasterise");
  return figures;
}

/// A number of JSON as text, or a dash where there is none.
std::string text(const nlohmann::json& json, const char* pointer, int digits, double scale = 1) {
  const nlohmann::json::json_pointer at(pointer);
  if (!json.contains(at)) return "-";
  char buffer[64];
  std::snprintf(buffer, sizeof buffer, "%.*f", digits, scale * json.at(at).get<double>());
  return buffer;
}

void print_row(const std::vector<std::string>& cells) {
  for (const std::string& cell : cells) std::printf("| %s ", cell.c_str());
  std::printf("|\n");
  std::fflush(stdout);
}

void print_head(const std::vector<std::string>& cells) {
  std::printf("\n");
  print_row(cells);
  for (std::size_t i = 0; i < cells.size(); ++i) std::printf("|---");
  std::printf("|\n");
}

void print_model(const Scene& scene) {
  const nlohmann::json& f = scene.figures;
  print_head({"triangles", "levels", "bytes a triangle", "build, s", "triangles a second", "store, MB",
              "Embree, build, s", "Embree, MB", "mesh, MB"});
  print_row({text(f, "/triangles", 0), text(f, "/levels", 0), text(f, "/bytes_a_triangle", 1),
             text(f, "/build_seconds", 1), text(f, "/build_triangles_a_second", 0),
             text(f, "/store_bytes", 0, 1e-6), text(f, "/embree/build_seconds", 1),
             text(f, "/embree/bytes", 0, 1e-6), text(f, "/mesh_bytes", 0, 1e-6)});
}

void print_times(const nlohmann::json& views) {
  print_head({"view", "triangles a pixel", "Embree, ms", "hybrid, ms", "rasterise, ms", "cast, ms",
              "splat, ms", "Embree / hybrid", "rasterise / hybrid", "cast, splatted, rasterised bricks",
              "frame, MB"});
  for (const nlohmann::json& v : views) {
    print_row(
        {v["name"].get<std::string>(), text(v, "/triangles_a_pixel", 2), text(v, "/milliseconds/embree", 1),
         text(v, "/milliseconds/hybrid", 1), text(v, "/milliseconds/rasterise", 1),
         text(v, "/milliseconds/cast", 1), text(v, "/milliseconds/splat", 1),
         text(v, "/embree_over_hybrid", 2), text(v, "/rasterise_over_hybrid", 2),
         text(v, "/methods/hybrid/cast_bricks", 0) + ", " + text(v, "/methods/hybrid/splatted_bricks", 0) +
             ", " + text(v, "/methods/hybrid/rasterised_bricks", 0),
         text(v, "/methods/hybrid/bytes", 1, 1e-6)});
  }
}

void print_differences(const nlohmann::json& views) {
  print_head(
      {"view", "method", "pixels inside", "missed", "stray", "depth, cells: median", "99 %", "PSNR, dB"});
  for (const nlohmann::json& v : views) {
    for (const Method& method : kMethods) {
      if (!v["methods"].contains(method.name)) continue;
      const nlohmann::json& of = v["methods"][method.name]["against_embree"];
      print_row({v["name"].get<std::string>(), method.name, text(of, "/pixels_inside", 0),
                 text(of, "/missed", 0), text(of, "/stray", 0), text(of, "/depth_median_cells", 2),
                 text(of, "/depth_99_cells", 2), text(of, "/psnr", 1)});
    }
  }
}

nlohmann::json measure(const Request& request, double millions) {
  const exec::Device cpu = exec::Device::cpu(request.threads);
  Scene scene;
  make_scene(request, cpu, millions, scene);
  print_model(scene);
  const scene::Camera fits = camera_that_fits(scene.model, double(request.width) / request.height);
  const surface::SurfaceView fitting = view_of(request, fits);
  const surface::SurfaceInstance instance = scene.whole->instance();
  surface::SurfaceDrawing drawing(cpu, fitting, std::span(&instance, 1));
  draw(drawing, fitting, instance);
  const Vec3d place = place_in_middle(fitting, drawing.film());
  const std::pair<const char*, scene::Camera> cameras[] = {
      {"fits", fits},
      {"far", camera_far(fits)},
      {"near", camera_near(fits, place)},
      {"grazing", camera_grazing(fits, place, scene.model)}};
  nlohmann::json views = nlohmann::json::array();
  for (const auto& [name, camera] : cameras) {
    if (!request.only.empty() && request.only != name) continue;
    views.push_back(measure_view(request, cpu, scene, name, view_of(request, camera)));
  }
  print_times(views);
  if (scene.embree != nullptr) {
    print_differences(views);
  } else {
    std::printf("\nThis build has no Embree 3: its columns and what differs from it are left out.\n");
  }
  scene.figures["views"] = views;
  return scene.figures;
}

/// False where the flags are no good.
bool read_flags(int argc, char** argv, Request& request) {
  if (argc < 2 || argc % 2 != 0 || argv[1][0] == '-') return false;
  request.out = argv[1];
  for (int i = 2; i < argc; i += 2) {
    const std::string flag = argv[i], value = argv[i + 1];
    if (flag == "--mesh") {
      request.mesh = value;
    } else if (flag == "--only") {
      request.only = value;
    } else if (flag == "--method") {
      request.method = value;
    } else if (flag == "--scratch") {
      request.scratch = value;
    } else if (flag == "--threads") {
      request.threads = std::atoi(value.c_str());
    } else if (flag == "--repeats") {
      request.repeats = std::atoi(value.c_str());
    } else if (flag == "--size") {
      if (std::sscanf(value.c_str(), "%ux%u", &request.width, &request.height) != 2) return false;
    } else if (flag == "--triangles") {
      request.millions.clear();
      std::istringstream list(value);
      for (std::string item; std::getline(list, item, ',');)
        request.millions.push_back(std::atof(item.c_str()));
    } else {
      return false;
    }
  }
  const bool positive =
      std::all_of(request.millions.begin(), request.millions.end(), [](double m) { return m > 0; });
  return positive && !request.millions.empty() && request.threads >= 0 && request.repeats > 0 &&
         request.width > 0 && request.height > 0 && request.width <= 16384 && request.height <= 16384;
}

int run(int argc, char** argv) {
  Request request;
  if (!read_flags(argc, argv, request)) {
    std::fprintf(stderr,
                 "usage: gvx_bench_surface OUT.json [--mesh FILE] [--triangles MILLIONS,...] [--threads N] "
                 "[--repeats N] [--size WIDTHxHEIGHT] [--only VIEW] [--method NAME] [--scratch FOLDER]\n");
    return 2;
  }
  nlohmann::json result = {{"mesh", request.mesh.empty() ? "bumpy sphere" : request.mesh},
                           {"threads", request.threads},
                           {"repeats", request.repeats},
                           {"width", request.width},
                           {"height", request.height},
                           {"models", nlohmann::json::array()}};
  for (const double millions : request.millions) {
    result["models"].push_back(measure(request, millions));
    std::ofstream(request.out) << result.dump(2) << '\n';
  }
  return 0;
}

}  // namespace
}  // namespace gvx::bench

int main(int argc, char** argv) {
  return gvx::bench::run(argc, argv);
}
