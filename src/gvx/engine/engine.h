/// \file
/// Engine: renders a volume that may be larger than memory. The volume is a tree of nodes; each node has a
/// brick, a small cube of voxels. Rays march through the bricks in memory, and mark those that they lack. A
/// producer reads or computes the marked bricks. They take the place of bricks that were not used for the
/// longest time. Then the rays go on. An exact picture ends when no ray lacks anything, a frame with a budget
/// when its time is over.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <unordered_set>
#include <vector>

#include "gvx/core/result.h"
#include "gvx/core/time_sum.h"
#include "gvx/engine/look.h"
#include "gvx/engine/preview_pace.h"
#include "gvx/engine/residency.h"
#include "gvx/engine/statistics.h"
#include "gvx/exec/device.h"
#include "gvx/produce/producer.h"
#include "gvx/produce/production_queue.h"
#include "gvx/produce/proxy.h"
#include "gvx/render/frame/film.h"
#include "gvx/render/frame/frame.h"
#include "gvx/render/march_pass.h"

namespace gvx::engine {

/// How an engine works; the defaults suit most programs.
struct EngineOptions {
  std::uint64_t memory_bytes = 512ull << 20;  ///< for bricks
  std::optional<PoolSizes> pools;             ///< in place of memory_bytes; for tests of tiny pools
  /// On a CPU: marches one ray at a time, not vectors of rays. This is slower. It defines what a picture is.
  bool one_ray_at_a_time = false;
  /// In frames with a budget: while no visible brick is missing, make bricks that a moving camera will need.
  bool prefetch = true;
  /// In frames with a budget: show coarser levels while the camera moves and frames take longer than their
  /// budget.
  bool adapt_levels = true;
  /// A closed mesh around all that can be seen: rays march only within it. Applies to the modes composite and
  /// isosurface.
  std::shared_ptr<const produce::Proxy> proxy = {};
  /// Called with a line of text if something is wrong that is not an error. Today this happens once, for the
  /// first brick with values beyond its node's bounds. It is called on the thread that called the engine.
  std::function<void(const std::string&)> warn = {};
};

/// Called with the number of the picture's rays that are finished, and of all its rays.
using RayProgress = std::function<void(std::uint64_t finished, std::uint64_t all)>;

/// Renders pictures of one volume on one device, one at a time. Not thread-safe.
class Engine {
 public:
  /// An error if the program has no kernels for this device and type of voxels, or memory_bytes is too
  /// little.
  static Result<std::unique_ptr<Engine>> create(const exec::Device& device,
                                                std::shared_ptr<const produce::Producer> producer,
                                                const EngineOptions& options);

  /// Sets the view; call this first. An error if the view is invalid. If the view changed, what was rendered
  /// is dropped.
  Status look(const render::View& asked);

  /// Renders until no ray lacks anything. The picture is the same for any cache size and number of threads.
  /// `progress` is called from this thread, a few times a second.
  Status render_exact(const RayProgress& progress = {});

  /// Renders for about this long. A preview of the bricks in memory comes first, in blocks of pixels that
  /// become finer; exact rays follow. Bricks that producers finish meanwhile are used. Further calls with the
  /// same view go on, until the picture is exact.
  Status render_for(std::chrono::nanoseconds budget);

  /// Is the picture the exact one?
  bool converged() const { return film_.has_value() && unfinished_tiles_.empty(); }
  /// The picture as far as it is rendered.
  render::Picture picture() const;
  /// The same into the caller's memory, in parallel. An error if rows do not fit, or if the depth of a
  /// projection is asked for. Depth belongs to the ray through the middle of a pixel. For an isosurface it is
  /// the surface; otherwise it is where the resident data hide half of what lies behind. It is measured along
  /// the view, as in depth buffers, not along the ray. To find it, these rays are marched again, one by one.
  Status picture(const render::PictureTarget& target);
  /// What the last call of render_exact() or render_for() did. Not cheap: it reads all pixels.
  Statistics statistics() const;
  const produce::TreeDescription& tree() const { return producer_->description(); }
  /// For tests.
  const Residency& residency() const { return residency_; }

 private:
  /// How far a preview has come: its stage and the first tile of it that is not drawn.
  struct PreviewProgress {
    std::uint32_t generation = 0;
    std::uint32_t first = 0;  ///< the block of its first stage; 0: a refresh, which has none
    std::uint32_t block = 0;  ///< 0: complete
    std::uint32_t tile = 0;

    bool complete() const { return block == 0; }
  };

  Engine(const exec::Device& device, std::shared_ptr<const produce::Producer> producer, PoolSizes sizes);

  Status look_coarsely();
  void cut_rays();
  render::Pass pass(const render::Frame& frame);
  void exact_pass(exec::Deadline deadline, const RayProgress& progress = {});
  void report(const RayProgress& progress);
  exec::Device host() const;
  render::Film::Development development() const;
  void write_depth(const render::PictureRows<float>& depth);
  void begin_preview(std::uint32_t first_block);
  void begin_refresh();
  bool preview_chunk(exec::Deadline deadline);
  Status coarse_preview(std::chrono::nanoseconds budget, exec::Deadline deadline);
  bool lacks_much() const;
  void preview_pass(exec::Deadline deadline);
  std::vector<produce::Job> collect();
  void ask(const std::vector<produce::Job>& jobs);
  void prefetch(exec::Deadline deadline);
  Status check_progress();
  Status take_finished();
  void look_at_bounds(const CommitCounts& counts);
  void begin_frame();
  void end_frame();

  exec::Device device_;
  bool one_ray_at_a_time_ = false;
  bool prefetch_ = true;
  bool adapts_levels_ = true;
  std::shared_ptr<const produce::Producer> producer_;
  Residency residency_;
  Look look_;
  produce::ProductionQueue queue_;
  std::shared_ptr<const produce::Proxy> proxy_;
  std::function<void(const std::string&)> warn_;
  std::uint64_t broken_bounds_ = 0;  // bricks of all frames
  exec::Buffer<RayInterval> spans_;  // of the film's rays in it; none: rays are not cut
  std::optional<render::View> view_;
  std::optional<render::Frame> frame_;
  std::optional<render::Frame> moving_frame_;  // what previews show instead
  double moving_bias_ = 0;                     // by how many levels that is coarser
  PreviewPace pace_;
  bool shows_something_ = false;  // a first stage of this view was drawn
  bool judged_ = true;            // this view's first frame has ended, or its camera does not move
  std::optional<render::Film> film_;
  std::vector<std::uint32_t> unfinished_tiles_;
  exec::Buffer<std::uint32_t> tile_list_, tile_flags_;
  std::size_t window_ = 0;        // of unfinished tiles, how many run at a time
  std::size_t exact_cursor_ = 0;  // in unfinished_tiles_: where a pass that was cut off goes on
  Eviction eviction_ = Eviction::unused;
  bool crowded_ = false;                             // rays wanted more than there was room for
  std::uint64_t lone_ray_ = render::Pass::kAllRays;  // that runs where memory is too small for more
  int stuck_passes_ = 0;                             // in which no ray of a lone screen tile came further
  std::uint64_t progress_ = 0;
  std::uint32_t stamp_ = 0;
  PreviewProgress preview_;
  bool data_came_ = false;                      // since the preview was begun
  int restarts_ = 0;                            // of this view's preview
  bool preview_at_rest_ = false;                // this view was drawn finely enough once: exact rays run
  std::optional<scene::Camera> camera_before_;  // that was looked with before this one, if it moves
  std::optional<render::Film> ahead_;           // of the picture that is prefetched for
  bool prefetching_ = false;                    // all that the queue makes is for later
  bool rays_marched_ = false;                   // in this frame
  std::unordered_set<produce::Job, produce::JobHash> for_later_;  // prefetched and not yet asked for
  std::chrono::steady_clock::time_point frame_start_;
  std::chrono::steady_clock::time_point reported_;  // when progress was said last
  std::chrono::nanoseconds overshoot_{0};           // by which frames were late
  std::chrono::nanoseconds first_stage_{0};         // that the last preview's took
  Statistics statistics_;
  TimeSum marching_, committing_, waiting_;
  std::chrono::nanoseconds waited_before_{0};  // waiting_ when the frame before began
};

}  // namespace gvx::engine
