/// \file
/// Viewer: looks at a world of objects, and renders what it sees: one picture after the other, exact or
/// within a time. Many viewers share a cache; each has its own camera, size, mode and transfer functions.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "gvx/core/result.h"
#include "gvx/core/time_sum.h"
#include "gvx/engine/cache.h"
#include "gvx/engine/exact_rays.h"
#include "gvx/engine/frame_timer.h"
#include "gvx/engine/look_ahead.h"
#include "gvx/engine/preview_pace.h"
#include "gvx/engine/preview_rays.h"
#include "gvx/engine/seen_surfaces.h"
#include "gvx/engine/seen_world.h"
#include "gvx/engine/statistics.h"
#include "gvx/engine/world.h"
#include "gvx/render/frame/film.h"
#include "gvx/render/march_pass.h"
#include "gvx/scene/proxy.h"

namespace gvx::engine {

/// How a viewer works; the defaults suit most programs.
struct ViewerOptions {
  /// On a CPU: marches one ray at a time, not vectors of rays. This is slower. It defines what a picture is.
  bool one_ray_at_a_time = false;
  /// In frames with a budget: while no visible brick is missing, make bricks that a moving camera will need.
  bool prefetch = true;
  /// In frames with a budget: show coarser levels while the camera moves and frames take longer than their
  /// budget.
  bool adapt_levels = true;
  /// A closed mesh around all that can be seen: rays march only within it. Applies to the modes composite and
  /// isosurface.
  std::shared_ptr<const scene::Proxy> proxy = {};
};

/// For one thread at a time. Viewers of one cache may be used by different threads at once: they take turns.
class Viewer {
 public:
  /// The volumes that it looks at must be of this cache.
  explicit Viewer(std::shared_ptr<Cache> cache, const ViewerOptions& options = {});
  ~Viewer();
  Viewer(const Viewer&) = delete;
  Viewer& operator=(const Viewer&) = delete;

  /// Sets what is seen, and how; call this first. An error if the view is invalid: then what was set before
  /// stays. If anything changed, what was rendered is dropped. Of the view all counts but its ObjectLook:
  /// each object has its own.
  Status look(const render::View& view, std::shared_ptr<const World> world);
  /// The same of a single volume, at its own place, as the view's ObjectLook says.
  Status look(const render::View& view, const std::shared_ptr<Volume>& volume);

  /// Renders until no ray lacks anything. The picture is the same for any cache size, number of threads and
  /// whatever other viewers do. `progress` is called from this thread, a few times a second.
  Status render_exact(const RayProgress& progress = {});

  /// Renders for about this long. A preview of the bricks in memory comes first, in blocks of pixels that
  /// become finer; exact rays follow. Bricks that producers finish meanwhile are used. Further calls with the
  /// same view go on, until the picture is exact.
  Status render_for(std::chrono::nanoseconds budget);

  /// Is the picture the exact one?
  bool converged() const {
    return film_.has_value() && exact_->finished() && (!surfaces_ || surfaces_->complete());
  }
  /// The picture as far as it is rendered; empty before look().
  render::Picture picture() const;
  /// The same into the caller's memory, in parallel. An error if rows do not fit, or if the depth of a
  /// projection is asked for. Depth belongs to the ray through the middle of a pixel. For an isosurface it is
  /// the surface; otherwise it is where the resident data hide half of what lies behind. It is measured along
  /// the view, as in depth buffers, not along the ray. To find it, these rays are marched again, one by one.
  Status picture(const render::PictureTarget& target);
  /// What the last call of render_exact() or render_for() did. Not cheap: it reads all pixels.
  Statistics statistics() const;

 private:
  Status make_film(const render::View& view, std::uint32_t projecting);
  Status look_coarsely();
  void cut_rays();
  render::Pass pass(const WorldFrames& frames);
  const WorldFrames& shown_frames() const { return moving_frames_ ? *moving_frames_ : *frames_; }
  const World& world() const { return seen_.world(); }
  exec::Device host() const;
  render::Film::Development development() const;
  void write_reach(const render::PictureTarget& target);
  int levels() const;
  Status out_of_memory() const;

  void see_surfaces();
  void begin_rays();
  bool has_volumes() const { return !world().volumes().empty(); }

  // A frame's parts, with the turn.
  void begin_frame();
  void begin_pass() { cache_->begin_pass(*client_); }
  std::vector<produce::ElementKey> limit_surfaces(const std::vector<Cache::SurfaceElement>& lacking);
  Status draw_surfaces(exec::FairMutex::Turn& turn);
  Status draw_surfaces_roughly(exec::FairMutex::Turn& turn, exec::Deadline deadline);
  Status show_roots(exec::FairMutex::Turn& turn);
  Status march_to_the_end(exec::FairMutex::Turn& turn, const RayProgress& progress);
  void march_exactly(exec::Deadline deadline, const RayProgress& progress);
  Status draw_coarsely(std::chrono::nanoseconds budget, exec::Deadline deadline);
  void ask();
  Status commit();
  Status wait(exec::FairMutex::Turn& turn, exec::Deadline deadline, bool keep_turn);
  void prefetch(exec::Deadline deadline);
  void report(const RayProgress& progress);

  std::shared_ptr<Cache> cache_;
  ViewerOptions options_;
  Cache::Client* client_;

  std::optional<render::View> view_;
  std::optional<WorldFrames> frames_;
  std::optional<WorldFrames> moving_frames_;  // what previews show instead
  double moving_bias_ = 0;                    // by how many levels that is coarser
  SeenWorld seen_;
  exec::Buffer<RayInterval> spans_;  // of the film's rays in the proxy; none: rays are not cut

  std::optional<SeenSurfaces> surfaces_;                  // none: the world has none
  std::vector<produce::ElementKey> lacking_of_surfaces_;  // of what a budget's frame shows

  std::optional<render::Film> film_;
  std::optional<ExactRays> exact_;
  std::optional<PreviewRays> preview_;
  PreviewPace pace_;
  FrameTimer timer_;
  LookAhead ahead_;
  bool crowded_ = false;          // rays wanted more than there was room for
  bool judged_ = true;            // this view's first frame has ended, or its camera does not move
  bool data_came_ = false;        // since the preview was begun
  int restarts_ = 0;              // of this view's preview
  bool preview_at_rest_ = false;  // this view was drawn finely enough once: exact rays run
  bool rays_marched_ = false;     // in this frame

  Statistics statistics_;
  TimeSum marching_, committing_, waiting_;
  std::chrono::nanoseconds waited_before_{0};       // waiting_ when the frame before began
  std::chrono::steady_clock::time_point reported_;  // when progress was said last
};

}  // namespace gvx::engine
