// How right are the engine's pictures? Compares them with a brute-force renderer's. Without a section all
// three run. --samples and --unlit change the pictures of the table, to tell errors apart.
//
//     gvx_bench_quality ROOT OUT [--pictures] [--seams] [--zoom] [--only NAME] [--png FOLDER] [--fresh]
//                       [--samples PER_VOXEL] [--unlit]

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "sections.h"

namespace gvx::bench {

std::string scene_title(const SceneName& scene) {
  return std::string(scene.volume) + "-" + scene.function;
}

bool wanted(const Request& request, const SceneName& scene) {
  return scene_title(scene).find(request.only) != std::string::npos;
}

void say(std::string& markdown, const std::string& line) {
  std::printf("%s\n", line.c_str());
  std::fflush(stdout);
  markdown += line + '\n';
}

}  // namespace gvx::bench

int main(int argc, char** argv) {
  using namespace gvx::bench;
  Request request;
  bool pictures = false, seams = false, zoom = false, usage = argc < 3;
  for (int i = 3; i < argc; ++i) {
    const std::string flag = argv[i];
    if (flag == "--pictures") {
      pictures = true;
    } else if (flag == "--seams") {
      seams = true;
    } else if (flag == "--zoom") {
      zoom = true;
    } else if (flag == "--fresh") {
      request.folders.fresh = true;
    } else if (flag == "--unlit") {
      request.lit = false;
    } else if (flag == "--samples" && i + 1 < argc) {
      request.samples_per_voxel = std::atof(argv[++i]);
    } else if (flag == "--only" && i + 1 < argc) {
      request.only = argv[++i];
    } else if (flag == "--png" && i + 1 < argc) {
      request.pictures = argv[++i];
    } else {
      usage = true;
    }
  }
  if (usage) {
    std::fprintf(stderr,
                 "usage: gvx_bench_quality ROOT OUT [--pictures] [--seams] [--zoom] [--only NAME] "
                 "[--png FOLDER] [--fresh] [--samples PER_VOXEL] [--unlit]\n");
    return 2;
  }
  const std::string out = argv[2];
  const char* data = std::getenv("GVX_TEST_DATA");
  request.folders.root = argv[1];
  request.folders.data = data != nullptr ? data : "";
  request.folders.cache = out + "/quality-cache";
  std::filesystem::create_directories(request.folders.cache);
  if (!request.pictures.empty()) std::filesystem::create_directories(request.pictures);

  const bool all = !pictures && !seams && !zoom;
  std::string markdown;
  nlohmann::json result;
  const auto write = [&] {
    std::ofstream(out + "/quality.json") << result.dump(2) << '\n';
    std::ofstream(out + "/quality.md") << markdown;
  };
  if (all || pictures) result["pictures"] = bench_pictures(request, markdown);
  write();
  if (all || seams) result["seams"] = bench_seams(request, markdown);
  write();
  if (all || zoom) result["zoom"] = bench_zoom(request, markdown);
  write();
  return 0;
}
