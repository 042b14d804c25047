/// \file
/// What the systems under comparison have in common: a view read from a JSON file, and the loop that renders
/// when it is told to. Each system is a process of its own, so that none has another's threads or memory in
/// its way; compare.py tells them by turns.
///
/// Lines of standard input, each answered by one line:
///   view FILE    the JSON file's view from now on; a whole frame is rendered to warm up   -> ok
///   frame        a frame, the camera by turns kHair aside and in its place                -> milliseconds
///   save FILE    the last frame, 3 bytes a pixel, rows from the top                       -> ok
/// The program ends when its input does. Errors go to standard error, and the program ends with status 1.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "gvx/core/result.h"
#include "gvx/scene/camera.h"
#include "gvx/scene/lighting.h"
#include "gvx/scene/transfer_function.h"

namespace gvx::bench {

/// In voxels, to the right: too little to be seen, enough for the view to be another one and rendered anew.
inline constexpr double kHair = 0.001;

/// Of a volume of unit voxels, the first voxel's centre at the origin of the world.
struct PeerView {
  std::uint32_t width = 0, height = 0;
  scene::Camera camera;
  scene::TransferFunction function;
  scene::Lighting lighting;
};

/// Fields as in a scene file (docs/scene-file.md), all of them there.
Result<PeerView> read_view(const std::string& path);

/// The camera, moved to its right by kHair.
scene::Camera moved_aside(scene::Camera camera);

class PeerSystem {
 public:
  virtual ~PeerSystem() = default;
  /// Does what is done once for a view and not again for each frame.
  virtual Status look(const PeerView& view) = 0;
  /// Renders a whole frame from this camera; the milliseconds that it took.
  virtual Result<double> frame(const scene::Camera& camera) = 0;
  /// The last frame, over black.
  virtual std::vector<std::uint8_t> rgb() const = 0;
};

/// Answers standard input until it ends; the program's exit status.
int serve(PeerSystem& system);

}  // namespace gvx::bench
