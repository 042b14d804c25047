#include <cmath>
#include <cstdio>
#include <numeric>

#include "metrics.h"
#include "sections.h"

namespace gvx::bench {
namespace {

constexpr std::uint32_t kEdges[] = {8, 16, 32};
// What of a ray's opacity counts as the first thing to see.
constexpr double kSeen = 0.3;

/// Pixels whose ray first sees something within half a voxel of a face of a brick of 8^3 voxels, both of the
/// level sampled there; those that see nothing are neither.
struct FacePixels {
  std::vector<std::size_t> at_face, elsewhere;
};

FacePixels face_pixels(const Volume& volume, const BruteForce& brute_force, const render::View& view) {
  const scene::CameraView camera = scene::make_view(view.camera, view.width, view.height).value();
  const Affine3 world_to_voxel = inverse(volume.dense->voxel_to_world());
  const Affine3& place = volume.dense->voxel_to_world();
  const double widest = std::max({length(place.column[0]), length(place.column[1]), length(place.column[2])});
  FacePixels pixels;
  for (std::uint32_t i = 0; i < view.width * view.height; ++i) {
    const Ray ray = camera.pixel_ray(i % view.width, i / view.width);
    const auto t = brute_force.depth(ray, kSeen);
    if (!t) continue;
    const double cone = camera.pixel * *t / widest;
    const double voxel = std::exp2(std::max(0.0, std::floor(std::log2(cone))));
    const Vec3d p = world_to_voxel.point(ray.at(*t));
    bool near_face = false;
    for (int axis = 0; axis < 3; ++axis) {
      const double bricks = p[axis] / (8 * voxel);
      near_face = near_face || std::abs(bricks - std::round(bricks)) * 8 <= 0.5;
    }
    (near_face ? pixels.at_face : pixels.elsewhere).push_back(i);
  }
  return pixels;
}

std::vector<float> pick(const std::vector<float>& values, const std::vector<std::size_t>& which) {
  std::vector<float> picked;
  for (const std::size_t i : which) picked.push_back(values[i]);
  return picked;
}

double mean(const std::vector<float>& values) {
  const double count = static_cast<double>(values.size());
  return values.empty() ? 0 : std::accumulate(values.begin(), values.end(), 0.0) / count;
}

}  // namespace

nlohmann::json bench_seams(const Request& request, std::string& markdown) {
  say(markdown,
      "Pictures of the same volume in bricks of 8, 16 and 32. |d|: absolute difference, the greatest of "
      "three "
      "colours. At faces: the ray first sees something within half a voxel of a face of a brick of 8. "
      "chance: "
      "that |d| of a pixel at a face is greater than of one elsewhere (0.5: no seams).\n");
  say(markdown,
      "| scene | view | light | bricks | dB | 99.99 % of \\|d\\| | mean at faces | elsewhere | ratio | "
      "chance "
      "| z |\n|---|---|---|---|---|---|---|---|---|---|---|");
  nlohmann::json rows = nlohmann::json::array();
  for (const SceneName& scene : {SceneName{"head", "ct-bone"}, {"bonsai", "gray"}, {"foam", "haze"}}) {
    if (!wanted(request, scene)) continue;
    std::vector<Volume> volumes;
    for (const std::uint32_t m : kEdges) {
      auto opened = open_volume(scene.volume, m, request.folders);
      if (!opened.ok()) {
        std::fprintf(stderr, "%s: left out\n", opened.error().message.c_str());
        break;
      }
      volumes.push_back(std::move(opened).value());
    }
    if (volumes.size() < std::size(kEdges)) continue;
    const scene::TransferFunction function = function_of(scene.function, volumes[0]).value();
    const BruteForce brute_force(*volumes[0].dense, function);
    for (const NamedView& named : {middle_view(volumes[0], function), framed_view(volumes[0], function, 4)}) {
      const FacePixels pixels = face_pixels(volumes[0], brute_force, named.view);
      for (const bool lit : {false, true}) {
        render::View view = named.view;
        view.lighting.enabled = lit;
        std::vector<render::Picture> pictures;
        for (const Volume& volume : volumes) {
          pictures.push_back(render_exact(*open_engine(volume), view, false).picture);
        }
        for (const auto& [a, b] : {std::pair<std::size_t, std::size_t>{0, 1}, {0, 2}, {1, 2}}) {
          const std::vector<float> d = differences(pictures[a], pictures[b]);
          const std::vector<float> faces = pick(d, pixels.at_face), rest = pick(d, pixels.elsewhere);
          const RankTest test = rank_test(faces, rest);
          const double decibels = finite_psnr(pictures[a], pictures[b]), far_out = percentile(d, 0.9999);
          const double at_faces = mean(faces), elsewhere = mean(rest);
          const double ratio = elsewhere > 0 ? at_faces / elsewhere : 1;
          const std::string title = scene_title(scene),
                            bricks = std::to_string(kEdges[a]) + "/" + std::to_string(kEdges[b]);
          char line[256];
          std::snprintf(line, sizeof(line),
                        "| %s | %s | %s | %s | %.1f | %.5f | %.2e | %.2e | %.2f | %.3f | %.1f |",
                        title.c_str(), named.name.c_str(), lit ? "lit" : "unlit", bricks.c_str(), decibels,
                        far_out, at_faces, elsewhere, ratio, test.chance, test.z);
          say(markdown, line);
          rows.push_back({{"scene", title},
                          {"view", named.name},
                          {"lit", lit},
                          {"bricks", bricks},
                          {"psnr_db", decibels},
                          {"difference_9999", far_out},
                          {"mean_at_faces", at_faces},
                          {"mean_elsewhere", elsewhere},
                          {"chance", test.chance},
                          {"z", test.z},
                          {"pixels_at_faces", faces.size()},
                          {"pixels_elsewhere", rest.size()}});
        }
      }
    }
  }
  say(markdown, "");
  return rows;
}

}  // namespace gvx::bench
