/// \file
/// ExactRays: the rays of one exact picture, from their start to the last one's end. It knows which tiles of
/// the film are unfinished, how many of them memory has room for at a time, and whether they come on.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "gvx/exec/buffer.h"
#include "gvx/exec/device.h"
#include "gvx/render/frame/film.h"
#include "gvx/render/march_pass.h"

namespace gvx::engine {

/// Called with the number of the picture's rays that are finished, and of all its rays.
using RayProgress = std::function<void(std::uint64_t finished, std::uint64_t all)>;

class ExactRays {
 public:
  /// Of pictures of this many tiles.
  ExactRays(const exec::Device& device, std::uint32_t tiles)
      : device_(device), list_(device, tiles), flags_(device, tiles) {}

  /// All rays of the film are at their start.
  void begin(const render::Film& film);

  /// None of them marches.
  void end() { unfinished_.clear(); }

  bool finished() const { return unfinished_.empty(); }
  /// Do all rays run that are unfinished?
  bool all_run() const { return window_ >= unfinished_.size(); }
  /// Does no more than one tile of rays run?
  bool one_tile_runs() const { return window_ == 1; }

  /// How a march is cut into parts.
  struct Parts {
    exec::Deadline deadline = exec::no_deadline();
    std::chrono::nanoseconds interval{0};  ///< about so long takes a part; 0: parts do not matter
    std::function<bool()> goes_on = {};    ///< asked after each part
  };
  /// Marches the unfinished tiles that may run, and strikes out those that are finished. A march that is cut
  /// off goes on where it was cut, so that every tile has its turn.
  void march(render::Film& film, render::Pass pass, const Parts& parts);

  /// Fewer rays run where there is no room for what they want; more where there is.
  void adapt(bool crowded, std::uint32_t all_tiles);

  /// After a march: did any ray of the first unfinished tile come further? Where none does for longer than a
  /// descent of `levels` takes, one runs alone: memory may hold what it needs, though not what two do.
  bool came_on(render::Film& film, int levels);
  /// Did that not help for long?
  bool hopeless(int levels) const;
  /// Counts anew how long rays have stood still.
  void forgive();

  /// About how many of the film's rays are finished: some of the unfinished tiles' are looked at for all.
  std::uint64_t finished_rays(render::Film& film) const;

 private:
  exec::Device device_;
  std::vector<std::uint32_t> unfinished_;     // tiles
  exec::Buffer<std::uint32_t> list_, flags_;  // tiles of a march, and which of them have unfinished rays
  std::size_t window_ = 0;                    // how many of the unfinished run at a time
  std::size_t cursor_ = 0;                    // in unfinished_: where a march that was cut off goes on
  std::uint64_t lone_ray_ = render::Pass::kAllRays;  // that runs where memory is too small for more
  int stuck_ = 0;                                    // marches in which no ray of a lone tile came further
  std::uint64_t place_ = 0;                          // where its rays are
};

}  // namespace gvx::engine
