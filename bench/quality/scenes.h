/// \file
/// What the quality bench looks at: volumes, functions, and views from near to far.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "brute_force.h"
#include "gvx/core/result.h"
#include "gvx/engine/engine.h"
#include "gvx/render/frame/view.h"
#include "gvx/scene/value_statistics.h"

namespace gvx::bench {

/// Where files are: `cache` keeps stores, samples and reference pictures from run to run.
struct Folders {
  std::string root;  ///< of the repository
  std::string data;  ///< GVX_TEST_DATA, or empty
  std::string cache;
  bool fresh = false;  ///< reference pictures are made anew
};

/// A function on a volume.
struct SceneName {
  const char* volume;
  const char* function;  ///< a preset, or one of the functions of the bench itself
};

/// All of the table.
std::vector<SceneName> scene_names();

/// A volume as a store of bricks of m, and as an array.
struct Volume {
  std::string name, store_path;
  std::shared_ptr<const DenseVolume> dense;
  scene::ValueStatistics statistics;
};

/// Builds the volume's store anew, as the way stores are built is part of what is looked at.
Result<Volume> open_volume(const std::string& name, std::uint32_t m, const Folders& folders);

Result<scene::TransferFunction> function_of(const std::string& name, const Volume& volume);

/// A picture to make. A pixel is so many voxels (of the smallest spacing) wide at the camera's target.
struct NamedView {
  std::string name;
  std::uint32_t reference_rays = 4;  ///< along an axis of a pixel
  render::View view;
};

/// near: a quarter of a voxel, the detail with most structure; middle: one voxel, the middle of the volume;
/// far and farther: 4 and 8 voxels, all of the volume.
NamedView near_view(const Volume& volume, const scene::TransferFunction& function);
NamedView middle_view(const Volume& volume, const scene::TransferFunction& function);
NamedView framed_view(const Volume& volume, const scene::TransferFunction& function, double voxels_per_pixel);

/// The brute-force picture, from the cache if it is there.
Reference reference_picture(const std::string& name, const BruteForce& brute_force, const render::View& view,
                            std::uint32_t rays_per_axis, const Folders& folders);

struct EngineRun {
  render::Picture picture;
  double milliseconds = 0;  ///< of an exact frame; if timed, one that finds its bricks
  std::uint64_t samples = 0;
};

std::unique_ptr<engine::Engine> open_engine(const Volume& volume);

/// The view's exact picture; `timed` makes one of a ray a pixel before it, which brings the bricks.
EngineRun render_exact(engine::Engine& engine, const render::View& view, bool timed);

}  // namespace gvx::bench
