/// \file
/// CameraPath: a camera that moves through key frames; and orbit, around what it looks at.
#pragma once

#include <vector>

#include "gvx/core/result.h"
#include "gvx/scene/camera.h"

namespace gvx::scene {

struct KeyFrame {
  double frame = 0;
  Camera camera;

  constexpr bool operator==(const KeyFrame&) const = default;
};

/// Passes through every key frame exactly and has no corners in between: a Catmull-Rom spline with the frames
/// as its parameter (Barry, Goldman 1988), whose speed at a key frame is bounded by three times the mean
/// speed on either side, which keeps monotone stretches monotone (Fritsch, Carlson 1980). A camera that rests
/// between two key frames therefore rests, however fast it comes and goes.
class CameraPath {
 public:
  /// At least one key frame, ascending, all perspective or all orthographic, of one origin; otherwise an
  /// error that names the first one that is not so.
  static Result<CameraPath> create(std::vector<KeyFrame> key_frames);

  /// Before the first key frame and after the last one the camera rests.
  Camera at(double frame) const;

  const std::vector<KeyFrame>& key_frames() const { return key_frames_; }

 private:
  explicit CameraPath(std::vector<KeyFrame> key_frames) : key_frames_(std::move(key_frames)) {}

  std::vector<KeyFrame> key_frames_;
};

/// The camera so many times nearer to its target.
Camera zoom(const Camera& camera, double factor);

/// The camera turned about the axis through its target along its up, to the right as it sees it.
Camera orbit(const Camera& camera, double degrees);

}  // namespace gvx::scene
