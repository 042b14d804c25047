#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "metrics.h"
#include "sections.h"

namespace gvx::bench {
namespace {

constexpr int kFrames = 200;
constexpr double kOctaves = 1.5;
constexpr std::uint32_t kWidth = 96, kHeight = 72;

/// The view of frame i: a pixel is one voxel wide at first, and 2^kOctaves at last.
render::View view_of_frame(const Volume& volume, const scene::TransferFunction& function, int i) {
  render::View view = middle_view(volume, function).view;
  const double height =
      2 * std::tan(view.camera.fov_degrees * std::numbers::pi / 360) * kHeight / view.height;
  view.camera.fov_degrees = 2 * std::atan(height / 2) * 180 / std::numbers::pi;
  view.width = kWidth;
  view.height = kHeight;
  const Vec3d back = view.camera.eye - view.camera.target;
  view.camera.eye = view.camera.target + std::exp2(kOctaves * i / (kFrames - 1)) * back;
  return view;
}

/// By how much a step of the camera changes the engine's picture more than the reference's.
struct Excess {
  double most = 0, root_mean_square = 0;
};

Excess excess(const render::Picture& engine_before, const render::Picture& engine_after,
              const std::vector<float>& reference_step) {
  Excess result;
  const std::vector<float> step = differences(engine_before, engine_after);
  for (std::size_t i = 0; i < step.size(); ++i) {
    const double more = std::max(0.0, double(step[i]) - double(reference_step[i]));
    result.most = std::max(result.most, more);
    result.root_mean_square += more * more;
  }
  result.root_mean_square = std::sqrt(result.root_mean_square / static_cast<double>(step.size()));
  return result;
}

}  // namespace

nlohmann::json bench_zoom(const Request& request, std::string& markdown) {
  say(markdown,
      "200 frames, 96x72, away from the object by 1.5 octaves (a pixel is 1 to 2.83 voxels wide). Excess: by "
      "how much a step changes a pixel of the engine's more than of the reference's (16 rays a pixel); RMS "
      "over a frame's pixels.\n");
  say(markdown,
      "| scene | level of detail | antialias | most | in frame | worst RMS | in frame | median RMS | ms |\n"
      "|---|---|---|---|---|---|---|---|---|");
  nlohmann::json rows = nlohmann::json::array();
  for (const SceneName& scene : {SceneName{"head", "ct-bone"}, {"foam", "walls"}}) {
    if (!wanted(request, scene)) continue;
    auto opened = open_volume(scene.volume, 16, request.folders);
    if (!opened.ok()) {
      std::fprintf(stderr, "%s: left out\n", opened.error().message.c_str());
      continue;
    }
    const Volume volume = std::move(opened).value();
    const scene::TransferFunction function = function_of(scene.function, volume).value();
    const std::string title = scene_title(scene);
    const BruteForce brute_force(*volume.dense, function);
    std::vector<std::vector<float>> reference_steps;
    render::Picture before;
    for (int i = 0; i < kFrames; ++i) {
      const render::View view = view_of_frame(volume, function, i);
      const render::Picture picture =
          reference_picture(title + "-zoom", brute_force, view, 4, request.folders).picture;
      if (i > 0) reference_steps.push_back(differences(before, picture));
      before = picture;
    }
    for (const bool level_of_detail : {true, false}) {
      for (const std::uint32_t antialias : {1u, 2u}) {
        const auto engine = open_engine(volume);
        Excess most, worst;
        int most_frame = 0, worst_frame = 0;
        double milliseconds = 0;
        std::vector<float> all;
        for (int i = 0; i < kFrames; ++i) {
          render::View view = view_of_frame(volume, function, i);
          view.level_of_detail = level_of_detail;
          view.antialias = antialias;
          EngineRun run = render_exact(*engine, view, false);
          milliseconds += run.milliseconds / kFrames;
          if (i > 0) {
            const Excess e = excess(before, run.picture, reference_steps[static_cast<std::size_t>(i - 1)]);
            all.push_back(static_cast<float>(e.root_mean_square));
            if (e.most > most.most) most = e, most_frame = i;
            if (e.root_mean_square > worst.root_mean_square) worst = e, worst_frame = i;
          }
          before = std::move(run.picture);
        }
        const double median = percentile(all, 0.5);
        char line[200];
        std::snprintf(line, sizeof(line), "| %s | %s | %u | %.4f | %d | %.5f | %d | %.5f | %.1f |",
                      title.c_str(), level_of_detail ? "on" : "off", antialias, most.most, most_frame,
                      worst.root_mean_square, worst_frame, median, milliseconds);
        say(markdown, line);
        rows.push_back({{"scene", title},
                        {"level_of_detail", level_of_detail},
                        {"antialias", antialias},
                        {"most", most.most},
                        {"most_frame", most_frame},
                        {"worst_rms", worst.root_mean_square},
                        {"worst_rms_frame", worst_frame},
                        {"median_rms", median},
                        {"rms_by_frame", all},
                        {"ms", milliseconds}});
      }
    }
  }
  say(markdown, "");
  return rows;
}

}  // namespace gvx::bench
