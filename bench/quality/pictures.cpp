#include <cstdio>

#include "gvx/io/image.h"
#include "metrics.h"
#include "sections.h"

namespace gvx::bench {
namespace {

struct Variant {
  const char* name;
  std::uint32_t antialias;
  bool level_of_detail;
};
constexpr Variant kVariants[] = {
    {"aa1", 1, true}, {"aa2", 2, true}, {"aa4", 4, true}, {"full1", 1, false}, {"full4", 4, false}};

void save(const Request& request, const std::string& name, const render::Picture& picture) {
  if (request.pictures.empty()) return;
  const Status status = io::write_png(request.pictures + "/" + name + ".png", picture.width, picture.height,
                                      picture.to_8_bit());
  if (!status.ok()) std::fprintf(stderr, "%s\n", status.error().message.c_str());
}

std::string cell(double decibels, double similarity, const EngineRun& run) {
  char text[96];
  std::snprintf(text, sizeof(text), " %.1f %.3f %.0f ms %.2f M |", decibels, similarity, run.milliseconds,
                double(run.samples) / 1e6);
  return text;
}

}  // namespace

nlohmann::json bench_pictures(const Request& request, std::string& markdown) {
  say(markdown, "Each cell: PSNR in dB (peak 1, RGB, black background), SSIM, warm exact frame, samples.");
  say(markdown,
      "Floor: what the reference's own rays allow. full1, full4: level of detail off, antialias 1, 4.\n");
  say(markdown,
      "| scene | view | px | floor | aa1 | aa2 | aa4 | full1 | full4 "
      "|\n|---|---|---|---|---|---|---|---|---|");
  nlohmann::json rows = nlohmann::json::array();
  Volume volume;
  for (const SceneName& scene : scene_names()) {
    if (!wanted(request, scene)) continue;
    if (volume.name != scene.volume) {
      auto opened = open_volume(scene.volume, 16, request.folders);
      if (!opened.ok()) {
        std::fprintf(stderr, "%s: left out\n", opened.error().message.c_str());
        continue;
      }
      volume = std::move(opened).value();
    }
    const scene::TransferFunction function = function_of(scene.function, volume).value();
    const BruteForce brute_force(*volume.dense, function);
    for (NamedView named : {near_view(volume, function), middle_view(volume, function),
                            framed_view(volume, function, 4), framed_view(volume, function, 8)}) {
      const std::string title = scene_title(scene), file = title + "-" + named.name;
      named.view.lighting.enabled = request.lit;
      const Reference reference =
          reference_picture(file, brute_force, named.view, named.reference_rays, request.folders);
      // The mean of two halves is off by half of their difference.
      const double floor = finite_psnr(reference.half[0], reference.half[1]) + 6.02;
      save(request, file + "-reference", reference.picture);
      nlohmann::json row = {
          {"scene", title}, {"view", named.name}, {"pixels", named.view.height}, {"floor_db", floor}};
      char head[160];
      std::snprintf(head, sizeof(head), "| %s | %s | %u | %.1f |", title.c_str(), named.name.c_str(),
                    named.view.height, floor);
      std::string line = head;
      const auto engine = open_engine(volume);
      for (const Variant& variant : kVariants) {
        // From near by, rays ask for the finest level as it is.
        if (!variant.level_of_detail &&
            (named.name == "near" || (named.name == "middle" && variant.antialias == 4))) {
          line += " |";
          continue;
        }
        render::View view = named.view;
        view.antialias = variant.antialias;
        view.samples_per_voxel = request.samples_per_voxel;
        view.level_of_detail = variant.level_of_detail;
        const EngineRun run = render_exact(*engine, view, true);
        const double decibels = finite_psnr(run.picture, reference.picture);
        const double similarity = ssim(run.picture, reference.picture);
        line += cell(decibels, similarity, run);
        row[variant.name] = {
            {"psnr_db", decibels}, {"ssim", similarity}, {"ms", run.milliseconds}, {"samples", run.samples}};
        save(request, file + "-" + variant.name, run.picture);
      }
      say(markdown, line);
      rows.push_back(row);
    }
  }
  say(markdown, "");
  return rows;
}

}  // namespace gvx::bench
