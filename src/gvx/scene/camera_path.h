/// \file
/// CameraPath: a camera that moves through key frames. zoom() and orbit() move a camera relative to its
/// target.
#pragma once

#include <vector>

#include "gvx/core/result.h"
#include "gvx/scene/camera.h"

namespace gvx::scene {

/// The camera at one frame of a path; frames may be fractions.
struct KeyFrame {
  double frame = 0;
  Camera camera;

  constexpr bool operator==(const KeyFrame&) const = default;
};

/// A smooth path that passes through every key frame exactly. It is a Catmull-Rom spline with the frame as
/// its parameter (Barry, Goldman 1988). Its speed at a key frame is at most three times the mean speed on
/// either side, so it does not overshoot (Fritsch, Carlson 1980). Between two equal key frames the camera
/// rests.
class CameraPath {
 public:
  /// Takes one or more key frames in ascending order. All are perspective or all orthographic, and all have
  /// the same origin. The error names the first key frame that breaks this.
  static Result<CameraPath> create(std::vector<KeyFrame> key_frames);

  /// Before the first key frame and after the last one the camera rests.
  Camera at(double frame) const;

  const std::vector<KeyFrame>& key_frames() const { return key_frames_; }

 private:
  explicit CameraPath(std::vector<KeyFrame> key_frames) : key_frames_(std::move(key_frames)) {}

  std::vector<KeyFrame> key_frames_;
};

/// The camera, `factor` times nearer to its target.
Camera zoom(const Camera& camera, double factor);

/// The camera, moved around its target to its own right. The axis goes through the target along up.
Camera orbit(const Camera& camera, double degrees);

}  // namespace gvx::scene
