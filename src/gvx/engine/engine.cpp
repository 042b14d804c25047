#include "gvx/engine/engine.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <new>
#include <numeric>
#include <string>
#include <utility>

#include "gvx/exec/parallel.h"
#include "gvx/render/vectors/instruction_set.h"

namespace gvx::engine {
namespace {

using Clock = std::chrono::steady_clock;

// Tiles that a budget frame works on between two looks at what producers have finished.
constexpr std::uint32_t kPreviewChunk = 128;
// What a frame of too short a budget spends on rendering all the same: the small unit of work.
constexpr std::chrono::microseconds kLeastWork(200);
// A frame stops earlier by what the ones before were late, at most by one in so many parts of its budget;
// late ones are forgotten over some frames.
constexpr int kMostOfBudget = 4;
constexpr int kFramesToForget = 16;
// And by one in so many parts in any case: those that end late are few then.
constexpr int kSpareOfBudget = 20;
// Of a preview's stages after the first, the finest that is drawn again while data comes in; and in how many
// frames of a view.
constexpr std::uint32_t kCoarseBlock = 8;
constexpr int kMostRestarts = 60;
// Once this share of what coarse blocks want is there, what comes later is for finer ones and exact rays.
constexpr double kSettledShare = 0.95;
// For how much of its budget a frame draws coarse blocks again, for the data that came.
constexpr double kSettlingShare = 0.4;
// What a frame at rest spends on showing new data coarsely before exact rays reach it: more where exact rays
// only wait.
constexpr double kLeastRefresh = 0.05, kMostRefresh = 0.4;

// Between two reports of how far an exact picture is.
constexpr std::chrono::milliseconds kReportInterval(250);

// Passes in which no ray of the first screen tile came further, beside those that it takes to descend to a
// brick, one a level: before one ray runs alone, and before it is taken for hopeless.
constexpr int kPatience = 4;
constexpr int kMostStuckPasses = 300;

// Production threads beside a GPU, whose own host thread mostly waits.
constexpr int kCudaProducers = 8;

std::chrono::nanoseconds share_of(std::chrono::nanoseconds budget, double share) {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(share * budget);
}

Status check(const produce::TreeDescription& tree) {
  if (tree.max_level >= kMaxLevels) {
    return Error{"volume: " + std::to_string(tree.max_level + 1) + " levels; the renderer knows " +
                 std::to_string(kMaxLevels)};
  }
  return check_placement(tree.tree_to_world);
}

}  // namespace

Result<std::unique_ptr<Engine>> Engine::create(const exec::Device& device,
                                               std::shared_ptr<const produce::Producer> producer,
                                               const EngineOptions& options) {
  GVX_TRY(render::check_processor());
  GVX_TRY(check(producer->description()));
  GVX_TRY(render::check_kernels(device, producer->description().format.type, producer->description().n,
                                producer->description().m));
  PoolSizes sizes;
  if (options.pools) {
    sizes = *options.pools;
    if (sizes.tiles < producer->description().max_level + 2 || sizes.bricks < 2) {
      return Error{"memory: the pools do not hold one path down the tree and two bricks"};
    }
  } else {
    GVX_ASSIGN(sizes, PoolSizes::fitting(options.memory_bytes, producer->description()));
  }
  std::unique_ptr<Engine> engine(new Engine(device, std::move(producer), sizes));
  engine->one_ray_at_a_time_ = options.one_ray_at_a_time;
  engine->prefetch_ = options.prefetch;
  engine->adapts_levels_ = options.adapt_levels;
  engine->proxy_ = options.proxy;
  engine->warn_ = options.warn;
  GVX_TRY(engine->residency_.plant_root());
  return engine;
}

Engine::Engine(const exec::Device& device, std::shared_ptr<const produce::Producer> producer, PoolSizes sizes)
    : device_(device),
      producer_(std::move(producer)),
      residency_(device, *producer_, sizes),
      look_(device, sizes.tiles, sizes.bricks),
      queue_(producer_, device.kind() == exec::DeviceKind::cpu ? device.threads() : kCudaProducers) {
  residency_.attach(look_);
}

Status Engine::look(const render::View& asked) {
  render::View view = asked;
  view.subrays = render::subrays_of(asked, producer_->description());
  view.antialias *= view.subrays;
  if (view_ && *view_ == view) return {};
  GVX_ASSIGN(auto frame,
             render::Frame::make(device_, view, producer_->description(), frame_ ? &*frame_ : nullptr));
  const bool sees_otherwise = !view_ || !(view_->functions == view.functions) || view_->mode != view.mode ||
                              view_->isovalue != view.isovalue ||
                              view_->classification != view.classification || view_->noise != view.noise;
  if (!view_ || view_->width != view.width || view_->height != view.height ||
      view_->antialias != view.antialias) {
    try {
      render::Film film(device_, view.width * view.antialias, view.height * view.antialias);
      const std::uint32_t tiles = film.grid().tiles();
      // Pictures that look ahead have no more tiles than this has of 32 x 32.
      const std::uint32_t ahead = exec::TileGrid{film.grid().width, film.grid().height, 32}.tiles();
      exec::Buffer<std::uint32_t> list(device_, std::max({tiles, kPreviewChunk, ahead}));
      exec::Buffer<std::uint32_t> flags(device_, tiles);
      film_ = std::move(film);
      pace_ = {};
      tile_list_ = std::move(list);
      tile_flags_ = std::move(flags);
    } catch (const std::bad_alloc&) {
      return Error{"picture size: no memory for " + std::to_string(view.width) + "x" +
                   std::to_string(view.height)};
    }
  }
  frame_ = std::move(frame);
  camera_before_.reset();
  if (view_ && !(view_->camera == view.camera)) {
    camera_before_ = view_->camera;
    view_->camera = view.camera;
    if (!(*view_ == view)) camera_before_.reset();  // another picture altogether
  }
  view_ = view;
  GVX_TRY(look_coarsely());
  cut_rays();
  if (sees_otherwise) {
    residency_.set_visibility(look_, frame_->view().visibility);
  } else {
    look_.move_tables(frame_->view().visibility);
  }
  film_->clear();
  unfinished_tiles_.resize(film_->grid().tiles());
  std::iota(unfinished_tiles_.begin(), unfinished_tiles_.end(), 0u);
  window_ = unfinished_tiles_.size();
  exact_cursor_ = 0;
  eviction_ = Eviction::unused;
  stuck_passes_ = 0;
  lone_ray_ = render::Pass::kAllRays;
  crowded_ = false;
  preview_at_rest_ = false;
  shows_something_ = false;
  restarts_ = 0;
  begin_preview(camera_before_ ? pace_.first_block() : render::Film::kLargestBlock);
  return {};
}

/// A moving camera's previews are of coarser levels where the ones before did not come to an end.
Status Engine::look_coarsely() {
  moving_frame_.reset();
  judged_ = !camera_before_;
  const double bias = pace_.level_bias();
  if (judged_ || !(bias > 0)) return {};
  render::View coarse = *view_;
  coarse.detail = std::max(coarse.detail * std::exp2(-bias), render::View::kLeastDetail);
  GVX_ASSIGN(auto frame, render::Frame::make(device_, coarse, producer_->description(), &*frame_));
  moving_frame_ = std::move(frame);
  moving_bias_ = bias;
  return {};
}

/// Finds what the proxy leaves of this view's rays.
void Engine::cut_rays() {
  const bool cuts = view_->mode == scene::Mode::composite || view_->mode == scene::Mode::isosurface;
  if (proxy_ == nullptr || !cuts) {
    spans_ = {};
    return;
  }
  const render::FrameView frame = frame_->view();
  const std::size_t rays = std::size_t(frame.width) * frame.height;
  if (spans_.size() != rays) spans_ = exec::Buffer<RayInterval>(device_, rays);
  const bool one_eye = !frame.camera.orthographic, eye_inside = one_eye && proxy_->inside(frame.eye_tree);
  exec::parallel_for(host(), frame.height, [&](std::size_t y) {
    for (std::uint32_t x = 0; x < frame.width; ++x) {
      const Ray from_eye = frame.camera.pixel_ray_from_eye(x, double(y));
      const Ray ray{frame.eye_tree + frame.world_to_tree.vector(from_eye.origin),
                    frame.world_to_tree.vector(from_eye.direction)};
      const bool inside = one_eye ? eye_inside : proxy_->inside(ray.origin);
      spans_.view()[y * frame.width + x] = proxy_->span(ray, inside);
    }
  });
}

render::Pass Engine::pass(const render::Frame& frame) {
  const produce::TreeDescription& tree = producer_->description();
  render::Pass pass;
  pass.n = tree.n;
  pass.m = tree.m;
  pass.frame = frame.view();
  const bool of_this_view = &frame == &*frame_ || (moving_frame_ && &frame == &*moving_frame_);
  if (of_this_view && spans_.size() > 0) pass.frame.proxy = spans_.view().data;
  pass.nodes = residency_.nodes().view();
  pass.hidden = look_.hidden();
  pass.bricks = residency_.bricks().bytes();
  pass.tile_usage = residency_.tile_usage();
  pass.brick_usage = residency_.brick_usage();
  pass.requests = residency_.requests();
  pass.number = stamp_;
  pass.lone_ray = lone_ray_;
  pass.cells = look_.cells();
  pass.one_ray_at_a_time = one_ray_at_a_time_;
  pass.epoch = film_->epoch();
  pass.blank_tiles = film_->blank_tiles();
  return pass;
}

/// Marches the unfinished tiles of the window and strikes out those that are finished. A pass that the
/// deadline cuts off goes on where it was cut, so that every tile has its turn.
/// With `progress` it is marched in parts, of which each takes about kReportInterval.
void Engine::exact_pass(exec::Deadline deadline, const RayProgress& progress) {
  const TimeSum::Span marching(marching_);
  ++statistics_.passes;
  const bool timed = deadline != exec::no_deadline();
  const std::size_t least_chunk = 4 * static_cast<std::size_t>(device_.threads()) + 4;
  std::size_t chunk = timed ? least_chunk : unfinished_tiles_.size();
  if (progress) chunk = std::max(least_chunk, chunk / 16);
  std::size_t end = std::min(window_, unfinished_tiles_.size());
  if (exact_cursor_ >= end || !timed) exact_cursor_ = 0;
  while (exact_cursor_ < end) {
    const std::size_t count = std::min(chunk, end - exact_cursor_);
    const Clock::time_point begin = Clock::now();
    const auto first = unfinished_tiles_.begin() + static_cast<std::ptrdiff_t>(exact_cursor_);
    const auto last = first + static_cast<std::ptrdiff_t>(count);
    std::copy(first, last, tile_list_.view().begin());
    for (auto tile = first; tile != last; ++tile) tile_flags_.view()[*tile] = 0;
    if (!render::march_exact(device_, pass(*frame_), film_->grid(), {tile_list_.view().data, count}, deadline,
                             film_->rays(), tile_flags_.view())) {
      return;  // some flags were not set; finished rays cost little the next time
    }
    const auto kept =
        std::remove_if(first, last, [&](std::uint32_t tile) { return tile_flags_.view()[tile] == 0; });
    const auto struck = static_cast<std::size_t>(last - kept);
    unfinished_tiles_.erase(kept, last);
    exact_cursor_ += count - struck;
    end -= struck;
    if (!progress) continue;
    report(progress);
    const double parts = (Clock::now() - begin) / std::chrono::duration<double>(kReportInterval);
    chunk =
        std::max(least_chunk, static_cast<std::size_t>(static_cast<double>(count) / std::max(parts, 1e-3)));
  }
  exact_cursor_ = 0;
}

/// Says how many rays are finished: of those of unfinished tiles, some are looked at for all.
void Engine::report(const RayProgress& progress) {
  const Clock::time_point now = Clock::now();
  if (!progress || now - reported_ < kReportInterval) return;
  reported_ = now;
  constexpr std::uint32_t kStep = 8;
  constexpr std::size_t kMostTiles = 1024;
  const exec::TileGrid grid = film_->grid();
  const auto rays = static_cast<std::uint64_t>(grid.width) * grid.height;
  std::uint64_t looked_at = 0, unfinished = 0;
  const std::size_t stride = unfinished_tiles_.size() / kMostTiles + 1;
  for (std::size_t i = 0; i < unfinished_tiles_.size(); i += stride) {
    const std::uint32_t x0 = unfinished_tiles_[i] % grid.tiles_x() * grid.tile;
    const std::uint32_t y0 = unfinished_tiles_[i] / grid.tiles_x() * grid.tile;
    for (std::uint32_t y = y0; y < std::min(y0 + grid.tile, grid.height); y += kStep) {
      for (std::uint32_t x = x0; x < std::min(x0 + grid.tile, grid.width); x += kStep) {
        const render::RayState& ray = film_->rays()[std::size_t(y) * grid.width + x];
        ++looked_at;
        unfinished += ray.epoch == film_->epoch() && ray.phase == render::RayPhase::finished ? 0 : 1;
      }
    }
  }
  const double of_tiles = static_cast<double>(unfinished_tiles_.size()) / grid.tiles();
  const double share =
      looked_at == 0 ? 0 : of_tiles * static_cast<double>(unfinished) / static_cast<double>(looked_at);
  progress(static_cast<std::uint64_t>((1 - share) * static_cast<double>(rays)), rays);
}

/// What rays lack, as far as there is room for it. Where they want more than that, fewer of them run at a
/// time; where even one tile of them does, what is in use may be pushed out: they have passed it.
std::vector<produce::Job> Engine::collect() {
  const TimeSum::Span committing(committing_);
  const std::vector<produce::Job> lacking = residency_.collect(stamp_, stamp_);
  statistics_.requests += residency_.requested();
  std::vector<produce::Job> jobs = lacking;
  eviction_ = Eviction::unused;
  crowded_ = residency_.limit_to_room(jobs, eviction_);
  if (crowded_ && jobs.empty() && window_ == 1) {
    jobs = lacking;
    eviction_ = Eviction::any;
    residency_.limit_to_room(jobs, eviction_);
  }
  window_ = crowded_ ? std::max<std::size_t>(1, window_ / 2)
                     : std::min<std::size_t>(window_ + window_ / 4 + 1, film_->grid().tiles());
  return jobs;
}

/// Has these made; while there are none, what is prefetched goes on.
void Engine::ask(const std::vector<produce::Job>& jobs) {
  if (jobs.empty() && prefetching_) return;
  queue_.replace(jobs);
  prefetching_ = false;
  for (const produce::Job& job : jobs) for_later_.erase(job);
}

Status Engine::render_exact(const RayProgress& progress) {
  GVX_CHECK(film_.has_value());
  reported_ = Clock::now();
  begin_frame();
  queue_.replace({});
  prefetching_ = false;
  while (!unfinished_tiles_.empty()) {
    ++stamp_;
    exact_pass(exec::no_deadline(), progress);  // render
    ask(collect());                             // collect
    while (!queue_.idle()) {
      {
        const TimeSum::Span waiting(waiting_);
        queue_.wait();  // produce
      }
      GVX_TRY(take_finished());  // evict, commit
      report(progress);
    }
    GVX_TRY(check_progress());
  }
  end_frame();
  return {};
}

/// Looks how far the first unfinished tile's rays have come. Where they stand still, one of them runs alone:
/// memory may hold what it needs, though not what two do. An error where that does not help for long.
Status Engine::check_progress() {
  // Changes with every ray's tick; a sum of ticks would round away the steps of the near ones.
  std::uint64_t progress = unfinished_tiles_.size();
  std::uint64_t first_unfinished = render::Pass::kAllRays;
  if (!unfinished_tiles_.empty()) {
    const exec::TileGrid grid = film_->grid();
    const std::uint32_t x0 = unfinished_tiles_[0] % grid.tiles_x() * grid.tile;
    const std::uint32_t y0 = unfinished_tiles_[0] / grid.tiles_x() * grid.tile;
    for (std::uint32_t y = y0; y < std::min(y0 + grid.tile, grid.height); ++y) {
      for (std::uint32_t x = x0; x < std::min(x0 + grid.tile, grid.width); ++x) {
        const std::size_t index = std::size_t(y) * grid.width + x;
        const render::RayState& ray = film_->rays()[index];
        progress += std::bit_cast<std::uint64_t>(ray.tick) + static_cast<std::uint64_t>(ray.phase);
        if (ray.phase != render::RayPhase::finished && first_unfinished == render::Pass::kAllRays) {
          first_unfinished = index;
        }
      }
    }
  }
  stuck_passes_ = progress == progress_ ? stuck_passes_ + 1 : 0;
  progress_ = progress;
  const bool came_on = lone_ray_ != render::Pass::kAllRays && lone_ray_ == first_unfinished;
  const int descent = static_cast<int>(producer_->description().max_level) + 1;
  if (stuck_passes_ >= descent + kPatience || came_on) {
    lone_ray_ = first_unfinished;
  } else {
    lone_ray_ = render::Pass::kAllRays;
  }
  if (stuck_passes_ <= descent + kMostStuckPasses) return {};
  return Error{"memory: " + std::to_string(residency_.nodes().tiles()) + " node tiles and " +
               std::to_string(residency_.bricks().slots()) + " bricks do not hold what one ray needs"};
}

void Engine::begin_preview(std::uint32_t first_block) {
  preview_ = {preview_.generation + 1, first_block, first_block, 0};
  data_came_ = false;
}

/// Of a picture that is drawn: there is no hurry.
void Engine::begin_refresh() {
  begin_preview(1);
  preview_.first = 0;
}

/// Draws the next few tiles of the preview; returns false where the deadline cut them off.
bool Engine::preview_chunk(exec::Deadline deadline) {
  const TimeSum::Span marching(marching_);
  const std::uint32_t block = preview_.block;
  const exec::TileGrid rays = film_->grid();
  const exec::TileGrid grid{(rays.width + block - 1) / block, (rays.height + block - 1) / block, 8};
  const std::uint32_t count = std::min(kPreviewChunk, grid.tiles() - preview_.tile);
  std::iota(tile_list_.view().begin(), tile_list_.view().begin() + count, preview_.tile);
  ++statistics_.passes;
  const render::Frame& frame = moving_frame_ ? *moving_frame_ : *frame_;
  if (!render::march_preview(device_, pass(frame), grid, {tile_list_.view().data, count}, deadline, block,
                             preview_.generation, film_->rays(), film_->preview())) {
    return false;  // what was drawn of them is not drawn again
  }
  preview_.tile += count;
  if (preview_.tile == grid.tiles()) {
    preview_.block = block / 2;
    preview_.tile = 0;
  }
  return true;
}

/// Draws the coarse stages, and draws them again while much data comes in: early in a frame better data shows
/// more than finer pixels do. A view's first stage is the small unit of work that is done in any case: a
/// frame always shows something.
Status Engine::coarse_preview(std::chrono::nanoseconds budget, exec::Deadline deadline) {
  const exec::Deadline settled = frame_start_ + share_of(budget, kSettlingShare);
  while (!preview_.complete() && (preview_.block == preview_.first || preview_.block >= kCoarseBlock)) {
    const std::uint32_t block = preview_.block;
    const bool in_any_case = block == preview_.first && !shows_something_;
    const auto begun = Clock::now();
    while (preview_.block == block) {
      if (!preview_chunk(in_any_case ? exec::no_deadline() : deadline)) return {};
    }
    if (block == preview_.first) {
      first_stage_ = Clock::now() - begun;
      shows_something_ = true;
    }
    ask(collect());
    GVX_TRY(take_finished());
    if (data_came_ && Clock::now() < settled && lacks_much()) begin_preview(preview_.first);
  }
  return {};
}

/// Did coarse blocks want much that was not there?
bool Engine::lacks_much() const {
  return film_->resident_share(std::max(kCoarseBlock, preview_.first)) < kSettledShare;
}

/// Draws preview stages, some tiles in any case, until the deadline or until the picture is drawn in single
/// pixels.
void Engine::preview_pass(exec::Deadline deadline) {
  while (!preview_.complete() && preview_chunk(deadline) && Clock::now() < deadline) {
  }
}

Status Engine::render_for(std::chrono::nanoseconds budget) {
  GVX_CHECK(film_.has_value());
  begin_frame();
  ++stamp_;
  if (!look_.hides(residency_.nodes().ranges(tree::NodePool::root()))) {
    GVX_ASSIGN(const CommitCounts planted, residency_.plant_root_brick());
    look_at_bounds(planted);
  }
  GVX_TRY(take_finished());
  // However short the budget, each frame gets somewhere.
  const exec::Deadline wanted = frame_start_ + budget;
  overshoot_ = std::min(overshoot_, budget / kMostOfBudget);
  const exec::Deadline deadline =
      std::max(wanted - overshoot_ - budget / kSpareOfBudget, Clock::now() + kLeastWork);
  // A picture at rest that is drawn already is refreshed with what came since, for a part of the time; not
  // where the refresh would push out what exact rays wait for.
  const bool refreshing = preview_.complete() && data_came_ && !crowded_;
  if (refreshing) begin_refresh();
  // One that is not drawn yet begins again with the data that came, though not for ever.
  if (!preview_at_rest_ && !refreshing && data_came_ && restarts_ < kMostRestarts && lacks_much()) {
    ++restarts_;
    begin_preview(preview_.first);
  }
  preview_at_rest_ = preview_at_rest_ || refreshing;
  const std::chrono::nanoseconds waited = waiting_.total() - waited_before_;
  waited_before_ = waiting_.total();
  const exec::Deadline refresh_deadline =
      frame_start_ + std::clamp(waited, share_of(budget, kLeastRefresh), share_of(budget, kMostRefresh));
  GVX_TRY(coarse_preview(budget, deadline));
  rays_marched_ = !unfinished_tiles_.empty();
  do {
    preview_pass(preview_at_rest_ ? refresh_deadline : deadline);  // render
    if (preview_.block < PreviewPace::kRestBlock) preview_at_rest_ = true;
    if (preview_at_rest_) {
      moving_frame_.reset();
      exact_pass(deadline);
    }
    if (prefetching_) GVX_TRY(take_finished());
    ask(collect());  // collect
    if (queue_.idle()) prefetch(deadline);
    while (!unfinished_tiles_.empty() && !queue_.idle() && !prefetching_ && Clock::now() < deadline) {
      {
        const TimeSum::Span waiting(waiting_);
        queue_.wait_until(deadline);  // produce
      }
      GVX_TRY(take_finished());  // evict, commit
    }
    if (preview_.complete()) ++stamp_;
  } while (!unfinished_tiles_.empty() && Clock::now() < deadline);
  // Work that was begun is finished: the next frames stop as much earlier as the last ones were late.
  const std::chrono::nanoseconds late = Clock::now() - deadline;
  overshoot_ = std::max(late, overshoot_ - overshoot_ / kFramesToForget);
  if (!judged_ && rays_marched_) {
    pace_.first_stage_took(std::chrono::duration<double>(first_stage_) / budget, lacks_much());
    pace_.frame_ended(preview_.block, adapts_levels_);
  }
  judged_ = true;
  statistics_.level_bias = moving_frame_ ? moving_bias_ : 0;
  end_frame();
  return {};
}

/// Asks for what a picture that is a few frames ahead of a moving camera would lack: a level deeper each
/// time, until it lacks nothing.
void Engine::prefetch(exec::Deadline deadline) {
  constexpr double kFramesAhead = 4;
  const bool all_tiles_run = window_ >= unfinished_tiles_.size();
  if (!prefetch_ || !camera_before_ || crowded_ || !all_tiles_run || exec::late(deadline)) return;
  const scene::Camera before = *camera_before_;
  render::View view = *view_;
  if (!(view.camera.origin == before.origin)) return;
  view.camera.eye = view.camera.eye + kFramesAhead * (view.camera.eye - before.eye);
  view.camera.target = view.camera.target + kFramesAhead * (view.camera.target - before.target);
  view.camera.up = view.camera.up + kFramesAhead * (view.camera.up - before.up);
  // Fewer rays, but as fine in what they want.
  const auto sparse = static_cast<std::uint32_t>(std::max(1.0, render::View::kMostDetail / view.detail));
  view.width = (view.width * view.antialias + sparse - 1) / sparse;
  view.height = (view.height * view.antialias + sparse - 1) / sparse;
  view.antialias = 1;
  view.detail *= sparse;
  const auto frame = render::Frame::make(device_, view, producer_->description(), &*frame_);
  if (!frame.ok()) {  // there the camera will not be
    camera_before_.reset();
    return;
  }
  constexpr std::uint32_t kTile = 8;
  const exec::TileGrid grid{view.width, view.height, kTile};
  if (grid.tiles() > tile_list_.size()) return;  // coarse pictures of high detail: not worth more memory
  if (!ahead_ || ahead_->grid().width != view.width || ahead_->grid().height != view.height) {
    try {
      ahead_.emplace(device_, view.width, view.height);
    } catch (const std::bad_alloc&) {
      ahead_.reset();
      camera_before_.reset();
      return;
    }
  }
  ahead_->clear();
  std::iota(tile_list_.view().begin(), tile_list_.view().begin() + grid.tiles(), 0u);
  render::Pass ahead = pass(frame.value());
  ahead.epoch = ahead_->epoch();
  ahead.blank_tiles = {};
  bool drawn = false;
  {
    const TimeSum::Span marching(marching_);
    drawn = render::march_preview(device_, ahead, grid, {tile_list_.view().data, grid.tiles()}, deadline, 1,
                                  1, ahead_->rays(), ahead_->preview());
  }
  std::vector<produce::Job> jobs;
  {
    const TimeSum::Span committing(committing_);
    jobs = residency_.collect(stamp_, stamp_);
  }
  if (jobs.empty() && drawn) camera_before_.reset();
  if (jobs.empty()) return;
  residency_.limit_to_room(jobs, Eviction::unused);
  if (!rays_marched_) {  // and touched what they see: only room that nothing is in may be taken
    const std::size_t free = residency_.bricks().slots() - residency_.resident_bricks();
    if (jobs.size() > free) jobs.resize(free);
  }
  eviction_ = Eviction::unused;
  queue_.replace(jobs);
  for_later_ = {jobs.begin(), jobs.end()};
  prefetching_ = true;
}

Status Engine::take_finished() {
  const TimeSum::Span committing(committing_);
  std::vector<produce::Produced> made = queue_.take_finished();
  // What nobody sees may fail: whoever comes to see it will hear of it.
  const auto failed = std::remove_if(made.begin(), made.end(), [&](const produce::Produced& p) {
    return for_later_.erase(p.job) != 0 && !p.status.ok();
  });
  if (failed != made.end()) camera_before_.reset();
  made.erase(failed, made.end());
  if (made.empty()) return {};
  statistics_.bricks_produced +=
      static_cast<std::uint64_t>(std::count_if(made.begin(), made.end(), [](const produce::Produced& p) {
        return p.job.kind == produce::JobKind::brick;
      }));
  GVX_ASSIGN(const CommitCounts counts, residency_.commit(std::move(made), eviction_));
  statistics_.bricks_evicted += counts.bricks_evicted;
  look_at_bounds(counts);
  data_came_ = data_came_ || (counts.committed > 0 && !prefetching_);
  return {};
}

/// Reports the first brick that breaks its bounds, and counts all.
void Engine::look_at_bounds(const CommitCounts& counts) {
  if (broken_bounds_ == 0 && counts.first_broken && warn_) warn_(counts.first_broken->message());
  broken_bounds_ += counts.broken_bounds;
}

void Engine::begin_frame() {
  stuck_passes_ = 0;
  lone_ray_ = render::Pass::kAllRays;
  frame_start_ = Clock::now();
  statistics_ = {};
}

void Engine::end_frame() {
  statistics_.frame_milliseconds =
      std::chrono::duration<double, std::milli>(Clock::now() - frame_start_).count();
}

Statistics Engine::statistics() const {
  Statistics s = statistics_;
  const render::FilmTotals totals = film_ ? film_->totals() : render::FilmTotals{};
  s.bricks_resident = residency_.resident_bricks();
  s.nodes_resident = residency_.resident_nodes();
  s.bricks_beyond_bounds = broken_bounds_;
  s.bytes_read = producer_->bytes_read();
  s.samples = totals.samples;
  s.converged = converged();
  const double wanted = static_cast<double>(std::max<std::uint64_t>(totals.wanted, 1));
  s.resident_share = s.converged ? 1.0 : static_cast<double>(totals.resident) / wanted;
  s.worst_lack = s.converged ? 0 : totals.worst_lack;
  s.peak_memory_bytes = peak_memory_bytes();
  const produce::ProductionTimes times = producer_->times();
  s.stages = {.reading = times.reading_milliseconds,
              .decoding = times.decoding_milliseconds,
              .producing = queue_.making_milliseconds(),
              .marching = marching_.milliseconds(),
              .committing = committing_.milliseconds(),
              .waiting = waiting_.milliseconds()};
  return s;
}

exec::Device Engine::host() const {
  return device_.kind() == exec::DeviceKind::cpu ? device_ : exec::Device::cpu();
}

render::Film::Development Engine::development() const {
  return {view_->antialias, view_->background, view_->opaque_background};
}

render::Picture Engine::picture() const {
  GVX_CHECK(film_.has_value());
  return film_->develop(host(), development());
}

Status Engine::picture(const render::PictureTarget& target) {
  GVX_CHECK(film_.has_value());
  GVX_TRY(render::check(target, view_->width, view_->height));
  const bool deep = view_->mode == scene::Mode::composite || view_->mode == scene::Mode::isosurface;
  if (!target.depth.values.empty() && !deep) {
    return Error{"picture: depth: only modes composite and isosurface have one"};
  }
  film_->develop(host(), development(), target);
  if (!target.depth.values.empty()) write_depth(target.depth);
  return {};
}

void Engine::write_depth(const render::PictureRows<float>& depth) {
  constexpr float kHalf = 0.5f;
  const std::uint32_t width = view_->width, rays = view_->antialias;
  const std::size_t stride = depth.stride > 0 ? depth.stride : width;
  const render::Pass all = pass(moving_frame_ ? *moving_frame_ : *frame_);
  const scene::CameraView& camera = all.frame.camera;
  exec::parallel_for(host(), view_->height, [&](std::size_t y) {
    for (std::uint32_t x = 0; x < width; ++x) {
      double along_view = INFINITY;
      if (film_->opacity(rays, x, static_cast<std::uint32_t>(y)) >= kHalf) {
        const auto middle = [&](double pixel) { return pixel * rays + 0.5 * (rays - 1); };
        const double ray_x = middle(x), ray_y = middle(static_cast<double>(y));
        const double distance = render::distance_to(all, ray_x, ray_y, kHalf);
        along_view = distance * dot(camera.pixel_ray_from_eye(ray_x, ray_y).direction, camera.forward);
      }
      depth.values[y * stride + x] = static_cast<float>(along_view);
    }
  });
}

}  // namespace gvx::engine
