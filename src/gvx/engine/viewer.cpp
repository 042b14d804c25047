#include "gvx/engine/viewer.h"

#include <algorithm>
#include <cmath>
#include <new>
#include <set>
#include <string>
#include <utility>

#include "gvx/exec/parallel.h"

namespace gvx::engine {
namespace {

using Clock = std::chrono::steady_clock;

// In how many frames of a view its coarse stages are drawn again for the data that came.
constexpr int kMostRestarts = 60;
// For how much of its budget a frame draws coarse blocks again, for the data that came.
constexpr double kSettlingShare = 0.4;
// What a frame at rest spends on showing new data coarsely before exact rays reach it: more where exact rays
// only wait.
constexpr double kLeastRefresh = 0.05, kMostRefresh = 0.4;

// Between two reports of how far an exact picture is.
constexpr std::chrono::milliseconds kReportInterval(250);
// How long an exact march goes on while another viewer waits.
constexpr std::chrono::milliseconds kTurn(20);

const Error kNoView{"picture: there is no view yet: call look() first"};

}  // namespace

Viewer::Viewer(std::shared_ptr<Cache> cache, const ViewerOptions& options)
    : cache_(std::move(cache)), options_(options), client_(cache_->add_client()) {}

Viewer::~Viewer() {
  {
    const exec::FairMutex::Turn turn = cache_->take_turn();
    seen_.end();
  }
  cache_->remove_client(client_);
}

Status Viewer::look(const render::View& view, const std::shared_ptr<Volume>& volume) {
  if (volume == nullptr) return Error{"volume: none given"};
  render::View asked = view;
  asked.subrays = render::subrays_of(view, volume->tree());
  asked.antialias *= asked.subrays;
  const std::shared_ptr<const World>& before = seen_.shared_world();
  const bool same = before != nullptr && before->objects().size() == 1 &&
                    before->objects()[0].volume == volume && before->objects()[0].shown == asked;
  if (same) return look(asked, before);
  GVX_ASSIGN(auto world, World::make({{volume, {}, asked}}));
  return look(asked, std::move(world));
}

Status Viewer::look(const render::View& view, std::shared_ptr<const World> world) {
  if (world == nullptr) return Error{"world: none given"};
  GVX_TRY(render::check_objects(cache_->device(), world->objects().size(), world->projecting()));
  if (view_ && *view_ == view && seen_.shared_world() == world) return {};
  GVX_ASSIGN(auto frames, WorldFrames::make(cache_->device(), view, *world, frames_ ? &*frames_ : nullptr));
  GVX_TRY(check_distance(frames.film(), *world));
  const bool other_size = !view_ || view_->width != view.width || view_->height != view.height ||
                          view_->antialias != view.antialias ||
                          world->projecting() != this->world().projecting();
  if (other_size) GVX_TRY(make_film(view, world->projecting()));
  ahead_.view_changed(view_, view);
  if (view_ && seen_.shared_world() != world && !(view_->sees_like(view) && world->objects().size() == 1))
    ahead_.stop();
  {
    const exec::FairMutex::Turn turn = cache_->take_turn();
    seen_.see(cache_->device(), std::move(world), frames);
    cache_->want(*client_, produce::Tier::ahead, {});
    client_->eviction = Eviction::unused;
  }
  frames_ = std::move(frames);
  view_ = view;
  see_surfaces();
  GVX_TRY(look_coarsely());
  cut_rays();
  begin_rays();
  crowded_ = false;
  preview_at_rest_ = false;
  restarts_ = 0;
  data_came_ = false;
  preview_->begin_view(ahead_.moving() ? pace_.first_block() : render::Film::kLargestBlock);
  return {};
}

/// All rays are at their start; where there are no volumes, none marches.
void Viewer::begin_rays() {
  film_->clear();
  exact_->begin(*film_);
  if (!has_volumes()) exact_->end();
}

/// Those of this view are to be drawn anew.
void Viewer::see_surfaces() {
  lacking_of_surfaces_.clear();
  const bool some = !world().surfaces().empty();
  if (!some) {
    surfaces_.reset();
  } else if (surfaces_) {
    surfaces_->see(*view_, frames_->film(), world());
  } else {
    surfaces_.emplace(host(), *view_, frames_->film(), world());
  }
  film_->show_surfaces(some ? surfaces_->film() : surface::SurfaceFilmView{}, !has_volumes());
}

Status Viewer::make_film(const render::View& view, std::uint32_t projecting) {
  try {
    render::Film film(cache_->device(), view.width * view.antialias, view.height * view.antialias,
                      projecting);
    ExactRays exact(cache_->device(), film.grid().tiles());
    PreviewRays preview(cache_->device(), film.grid());
    film_ = std::move(film);
    exact_ = std::move(exact);
    preview_ = std::move(preview);
    pace_ = {};
    return {};
  } catch (const std::bad_alloc&) {
    return Error{"picture size: no memory for " + std::to_string(view.width) + "x" +
                 std::to_string(view.height)};
  }
}

/// A moving camera's previews are of coarser levels where the ones before did not come to an end.
Status Viewer::look_coarsely() {
  moving_frames_.reset();
  judged_ = !ahead_.moving();
  const double bias = pace_.level_bias();
  if (judged_ || !(bias > 0)) return {};
  render::View coarse = *view_;
  coarse.detail = std::max(coarse.detail * std::exp2(-bias), render::View::kLeastDetail);
  GVX_ASSIGN(auto frames, WorldFrames::make(cache_->device(), coarse, world(), &*frames_));
  moving_frames_ = std::move(frames);
  moving_bias_ = bias;
  return {};
}

/// Finds what the proxy leaves of this view's rays.
void Viewer::cut_rays() {
  const bool cuts =
      world().objects().size() == 1 && has_volumes() && !scene::projects(world().objects()[0].shown.mode);
  const std::shared_ptr<const scene::Proxy>& proxy = options_.proxy;
  if (proxy == nullptr || !cuts) {
    spans_ = {};
    return;
  }
  const render::FrameView frame = frames_->frame(0).view();
  const render::FilmView& film = frames_->film();
  const std::size_t rays = std::size_t(film.width) * film.height;
  if (spans_.size() != rays) spans_ = exec::Buffer<RayInterval>(cache_->device(), rays);
  const bool one_eye = !film.camera.orthographic, eye_inside = one_eye && proxy->inside(frame.bundle.origin);
  exec::parallel_for(host(), film.height, [&](std::size_t y) {
    for (std::uint32_t x = 0; x < film.width; ++x) {
      const Ray from_eye = film.camera.pixel_ray_from_eye(x, double(y));
      const Ray ray{frame.bundle.origin + frame.world_to_tree.vector(from_eye.origin),
                    frame.world_to_tree.vector(from_eye.direction)};
      const bool inside = one_eye ? eye_inside : proxy->inside(ray.origin);
      spans_.view()[film.index(x, static_cast<std::uint32_t>(y))] = proxy->span(ray, inside);
    }
  });
}

render::Pass Viewer::pass(const WorldFrames& frames) {
  const bool of_this_view =
      frames.id() == frames_->id() || (moving_frames_ && frames.id() == moving_frames_->id());
  render::Pass pass;
  pass.film = frames.film();
  if (of_this_view && spans_.size() > 0) pass.film.proxy = spans_.view().data;
  pass.objects = seen_.views(frames);
  if (surfaces_ && of_this_view) pass.surfaces = surfaces_->film();
  pass.object_tiles = seen_.tiles(frames);
  pass.number = client_->pass;
  pass.one_ray_at_a_time = options_.one_ray_at_a_time;
  pass.epoch = film_->epoch();
  pass.blank_tiles = film_->blank_tiles();
  pass.projections = film_->projections();
  return pass;
}

int Viewer::levels() const {
  std::uint32_t most = 0;
  for (const Volume* volume : world().volumes()) most = std::max(most, volume->tree().max_level);
  return static_cast<int>(most) + 1;
}

Status Viewer::out_of_memory() const {
  if (!has_volumes()) return Error{"memory: it does not hold one brick of the surface"};
  std::uint64_t tiles = 0, bricks = 0;
  for (const Volume* volume : world().volumes()) {
    tiles += volume->residency().nodes().tiles();
    bricks += volume->residency().bricks().slots() - volume->residency().withheld_bricks();
  }
  return Error{"memory: " + std::to_string(tiles) + " node tiles and " + std::to_string(bricks) +
               " bricks do not hold what one ray needs"};
}

void Viewer::begin_frame() {
  timer_.begin();
  statistics_ = {};
  exact_->forgive();
  client_->bricks_made = client_->bricks_evicted = 0;
}

void Viewer::march_exactly(exec::Deadline deadline, const RayProgress& progress) {
  const TimeSum::Span marching(marching_);
  ++statistics_.passes;
  ExactRays::Parts parts;
  parts.deadline = deadline;
  const bool timed = deadline != exec::no_deadline();
  if (!timed && !cache_->has_one_client()) {
    parts.interval = kTurn;
    parts.goes_on = [&] {
      report(progress);
      return !cache_->contended();
    };
  } else if (!timed && progress) {
    parts.interval = kReportInterval;
    parts.goes_on = [&] {
      report(progress);
      return true;
    };
  }
  exact_->march(*film_, pass(*frames_), parts);
}

void Viewer::report(const RayProgress& progress) {
  const Clock::time_point now = Clock::now();
  if (!progress || now - reported_ < kReportInterval) return;
  reported_ = now;
  const exec::TileGrid grid = film_->grid();
  progress(exact_->finished_rays(*film_), static_cast<std::uint64_t>(grid.width) * grid.height);
}

/// Asks for what rays lack, as far as there is room for it. Where they want more than that, fewer of them run
/// at a time; where even one tile of them does, what is in use may be pushed out: they have passed it.
void Viewer::ask() {
  const TimeSum::Span committing(committing_);
  const std::vector<produce::ElementKey> lacking =
      cache_->collect(*client_, world().volumes(), statistics_.requests);
  std::vector<produce::ElementKey> elements = lacking;
  client_->eviction = Eviction::unused;
  crowded_ = cache_->limit_to_room(elements, client_->eviction);
  if (crowded_ && elements.empty() && exact_->one_tile_runs()) {
    elements = lacking;
    client_->eviction = Eviction::any;
    cache_->limit_to_room(elements, client_->eviction);
  }
  exact_->adapt(crowded_, film_->grid().tiles());
  elements.insert(elements.begin(), lacking_of_surfaces_.begin(), lacking_of_surfaces_.end());
  cache_->want(*client_, produce::Tier::visible, elements);
}

/// Takes in what was made; an error if something for this picture could not be.
Status Viewer::commit() {
  const TimeSum::Span committing(committing_);
  cache_->commit(*client_);
  data_came_ = data_came_ || std::exchange(client_->came, 0) > 0;
  if (std::exchange(client_->failed_ahead, false)) ahead_.stop();
  return std::exchange(client_->failed, Status());
}

/// Waits for something that the client wants, and takes it in. Meanwhile it is others' turn, if there are any
/// and the turn is not to be kept.
Status Viewer::wait(exec::FairMutex::Turn& turn, exec::Deadline deadline, bool keep_turn) {
  const bool alone = keep_turn || cache_->has_one_client();
  {
    const TimeSum::Span waiting(waiting_);
    if (!alone) turn.end();
    cache_->wait_until(*client_, deadline);
    if (!alone) {
      turn = cache_->take_turn();
      begin_pass();  // others' passes have come since
    }
  }
  return commit();
}

/// Those that there is room for; at least one, if there is any way to make room for it.
std::vector<produce::ElementKey> Viewer::limit_surfaces(const std::vector<Cache::SurfaceElement>& lacking) {
  client_->eviction = Eviction::unused;
  std::vector<produce::ElementKey> elements = cache_->limit_to_room(lacking, Eviction::unused);
  if (!elements.empty()) return elements;
  // What was drawn is not needed any more.
  client_->eviction = Eviction::any;
  return cache_->limit_to_room(lacking, Eviction::any);
}

/// Draws the exact picture's surfaces to the end.
Status Viewer::draw_surfaces(exec::FairMutex::Turn& turn) {
  while (!surfaces_->complete()) {
    begin_pass();
    std::vector<Cache::SurfaceElement> lacking;
    {
      const TimeSum::Span marching(marching_);
      ++statistics_.passes;
      lacking = surfaces_->advance();
    }
    if (surfaces_->complete()) break;
    statistics_.requests += lacking.size();
    const std::vector<produce::ElementKey> elements = limit_surfaces(lacking);
    if (elements.empty()) return out_of_memory();
    cache_->want(*client_, produce::Tier::visible, elements);
    const bool by_force = client_->eviction == Eviction::any;
    while (!cache_->idle(*client_)) GVX_TRY(wait(turn, exec::no_deadline(), by_force));
  }
  return {};
}

/// Draws surfaces with what is in memory, and asks for the rest. The first time of a view it waits until
/// there is something to show.
Status Viewer::draw_surfaces_roughly(exec::FairMutex::Turn& turn, exec::Deadline deadline) {
  while (true) {
    std::vector<Cache::SurfaceElement> lacking;
    {
      const TimeSum::Span marching(marching_);
      ++statistics_.passes;
      lacking = surfaces_->draw_resident();
    }
    data_came_ = false;
    lacking_of_surfaces_.clear();
    statistics_.requests += lacking.size();
    if (surfaces_->complete()) break;
    client_->eviction = Eviction::unused;
    lacking_of_surfaces_ = cache_->limit_to_room(lacking, Eviction::unused);
    cache_->want(*client_, produce::Tier::visible, lacking_of_surfaces_);
    const bool shows_none = surfaces_->counts().drawn() == 0;
    if (lacking_of_surfaces_.empty() || (!shows_none && exec::late(deadline))) break;
    const exec::Deadline until = shows_none ? exec::no_deadline() : deadline;
    while (!cache_->idle(*client_) && !exec::late(until)) GVX_TRY(wait(turn, until, true));
    if (!data_came_) break;
  }
  // What rays have marched ends elsewhere now.
  begin_rays();
  preview_->begin_again();
  return {};
}

Status Viewer::render_exact(const RayProgress& progress) {
  if (!film_) return kNoView;
  reported_ = Clock::now();
  exec::FairMutex::Turn turn = cache_->take_turn();
  begin_frame();
  cache_->want(*client_, produce::Tier::ahead, {});
  Status status = surfaces_ ? draw_surfaces(turn) : Status();
  if (status.ok() && has_volumes()) status = march_to_the_end(turn, progress);
  // What was wanted when something failed is nobody's concern now.
  if (!status.ok()) cache_->want(*client_, produce::Tier::visible, {});
  cache_->rest(*client_);
  statistics_.frame_milliseconds = timer_.milliseconds();
  return status;
}

Status Viewer::march_to_the_end(exec::FairMutex::Turn& turn, const RayProgress& progress) {
  while (!exact_->finished()) {
    begin_pass();
    march_exactly(exec::no_deadline(), progress);  // render
    ask();                                         // collect
    const bool came_on = exact_->came_on(*film_, levels());
    if (exact_->hopeless(levels())) return out_of_memory();
    // Rays that push out what is in use keep their turn until one has come on, and where memory is scarce
    // what came is used before it is another's turn: else viewers could take from each other what they need,
    // for ever.
    const bool by_force = client_->eviction == Eviction::any && !came_on;
    bool keep_turn = by_force;
    if (cache_->idle(*client_) && !keep_turn && cache_->contended()) {
      turn.end();
      turn = cache_->take_turn();
    }
    while (!cache_->idle(*client_)) {
      GVX_TRY(wait(turn, exec::no_deadline(), keep_turn));  // produce, evict, commit
      keep_turn = by_force || crowded_;
      report(progress);
    }
  }
  return {};
}

/// Draws the coarse stages, and draws them again while much data comes in: early in a frame better data shows
/// more than finer pixels do.
Status Viewer::draw_coarsely(std::chrono::nanoseconds budget, exec::Deadline deadline) {
  const exec::Deadline settled = timer_.after(budget, kSettlingShare);
  while (preview_->coarse()) {
    {
      const TimeSum::Span marching(marching_);
      ++statistics_.passes;
      if (!preview_->draw_stage(*film_, pass(shown_frames()), deadline)) return {};
    }
    ask();
    GVX_TRY(commit());
    if (data_came_ && Clock::now() < settled && preview_->lacks_much(*film_)) {
      preview_->begin_again();
      data_came_ = false;
    }
  }
  return {};
}

/// Has the roots' bricks made where a preview would have nothing else to show.
Status Viewer::show_roots(exec::FairMutex::Turn& turn) {
  std::vector<produce::ElementKey> roots;
  for (std::size_t i = 0; i < frames_->size(); ++i) {
    const std::size_t object = frames_->object(i);
    Residency& residency = world().objects()[object].volume->residency();
    if (seen_.look(object).hides(residency.nodes().ranges(tree::NodePool::root()))) continue;
    const auto root = residency.ask_for_root();
    if (root && std::find(roots.begin(), roots.end(), *root) == roots.end()) roots.push_back(*root);
  }
  if (roots.empty()) return {};
  client_->eviction = Eviction::any;
  cache_->limit_to_room(roots, Eviction::any);
  cache_->want(*client_, produce::Tier::visible, roots);
  while (!cache_->idle(*client_)) GVX_TRY(wait(turn, exec::no_deadline(), false));
  return {};
}

Status Viewer::render_for(std::chrono::nanoseconds budget) {
  if (!film_) return kNoView;
  exec::FairMutex::Turn turn = cache_->take_turn();
  begin_frame();
  begin_pass();
  GVX_TRY(show_roots(turn));
  GVX_TRY(commit());
  const exec::Deadline deadline = timer_.deadline(budget);
  if (surfaces_ && !surfaces_->complete()) GVX_TRY(draw_surfaces_roughly(turn, deadline));
  if (!has_volumes()) {
    timer_.end(deadline);
    statistics_.frame_milliseconds = timer_.milliseconds();
    if (surfaces_->complete()) cache_->rest(*client_);
    return {};
  }
  // A picture at rest that is drawn already is refreshed with what came since, for a part of the time; not
  // where the refresh would push out what exact rays wait for.
  const bool refreshing = preview_->complete() && data_came_ && !crowded_;
  if (refreshing) {
    preview_->begin_refresh();
    data_came_ = false;
  }
  // One that is not drawn yet begins again with the data that came, though not for ever.
  if (!preview_at_rest_ && !refreshing && data_came_ && restarts_ < kMostRestarts &&
      preview_->lacks_much(*film_)) {
    ++restarts_;
    preview_->begin_again();
    data_came_ = false;
  }
  preview_at_rest_ = preview_at_rest_ || refreshing;
  const std::chrono::nanoseconds waited = waiting_.total() - waited_before_;
  waited_before_ = waiting_.total();
  const exec::Deadline refresh_deadline = timer_.after(
      budget, std::clamp(std::chrono::duration<double>(waited) / budget, kLeastRefresh, kMostRefresh));
  GVX_TRY(draw_coarsely(budget, deadline));
  rays_marched_ = !exact_->finished();
  do {
    {
      const TimeSum::Span marching(marching_);
      preview_->draw_until(*film_, pass(shown_frames()),
                           preview_at_rest_ ? refresh_deadline : deadline);  // render
    }
    if (preview_->block() < PreviewPace::kRestBlock) preview_at_rest_ = true;
    if (preview_at_rest_) {
      moving_frames_.reset();
      if (!surfaces_ || surfaces_->complete()) march_exactly(deadline, {});
    }
    ask();              // collect
    GVX_TRY(commit());  // evict, commit
    if (cache_->idle(*client_)) prefetch(deadline);
    while (!exact_->finished() && !cache_->idle(*client_) && Clock::now() < deadline) {
      GVX_TRY(wait(turn, deadline, true));  // produce, evict, commit
    }
    if (preview_->complete()) begin_pass();
  } while (!exact_->finished() && Clock::now() < deadline);
  timer_.end(deadline);
  if (!judged_ && rays_marched_) {
    pace_.first_stage_took(std::chrono::duration<double>(preview_->first_stage_took()) / budget,
                           preview_->lacks_much(*film_));
    pace_.frame_ended(preview_->block(), options_.adapt_levels);
  }
  judged_ = true;
  statistics_.level_bias = moving_frames_ ? moving_bias_ : 0;
  statistics_.frame_milliseconds = timer_.milliseconds();
  if (exact_->finished()) cache_->rest(*client_);
  return {};
}

/// Asks for what a picture that is a few frames ahead of a moving camera would lack: a level deeper each
/// time, until it lacks nothing.
void Viewer::prefetch(exec::Deadline deadline) {
  if (surfaces_ || !options_.prefetch || !ahead_.moving() || crowded_ || !exact_->all_run() ||
      exec::late(deadline))
    return;
  const auto view = ahead_.next(*view_);
  if (!view) return;
  const auto frames = WorldFrames::make(cache_->device(), *view, world(), &*frames_);
  if (!frames.ok()) return ahead_.stop();  // there the camera will not be
  // What comes into sight there is looked at when it does.
  for (std::size_t i = 0; i < frames.value().size(); ++i) {
    if (!seen_.looks_at(frames.value().object(i))) return;
  }
  const exec::TileGrid large{film_->grid().width, film_->grid().height, 32};
  const auto picture = ahead_.picture(cache_->device(), *view, large.tiles());
  if (!picture) return;
  render::Pass ahead = pass(frames.value());
  ahead.epoch = picture->film->epoch();
  ahead.blank_tiles = {};
  bool drawn = false;
  {
    const TimeSum::Span marching(marching_);
    const render::TilesMarch tiles{ahead, picture->grid, picture->tiles, deadline};
    drawn = render::march_preview(cache_->device(),
                                  {tiles, 1, 1, picture->film->rays(), picture->film->preview()});
  }
  const TimeSum::Span committing(committing_);
  std::uint64_t ignored = 0;
  std::vector<produce::ElementKey> elements = cache_->collect(*client_, world().volumes(), ignored);
  if (elements.empty() && drawn) ahead_.stop();
  if (elements.empty()) return;
  cache_->limit_to_room(elements, Eviction::unused);
  if (!rays_marched_) {  // and touched what they see: only room that nothing is in may be taken
    std::size_t free = 0;
    for (const Volume* volume : world().volumes()) free += volume->residency().free_bricks();
    if (elements.size() > free) elements.resize(free);
  }
  client_->eviction = Eviction::unused;
  cache_->want(*client_, produce::Tier::ahead, elements);
}

Statistics Viewer::statistics() const {
  Statistics s = statistics_;
  const render::FilmTotals totals = film_ ? film_->totals() : render::FilmTotals{};
  produce::ProductionTimes times;
  // Other viewers' commits count, too, what was made for this one.
  exec::FairMutex::Turn turn = cache_->take_turn();
  for (const Volume* volume : view_ ? world().volumes() : std::span<Volume* const>()) {
    s.bricks_resident += volume->residency().resident_bricks();
    s.nodes_resident += volume->residency().resident_nodes();
    s.bricks_beyond_bounds += volume->broken_bounds();
    s.bytes_read += volume->producer()->bytes_read();
    times.reading_milliseconds += volume->producer()->times().reading_milliseconds;
    times.decoding_milliseconds += volume->producer()->times().decoding_milliseconds;
  }
  std::set<const Surface*> counted;
  for (const std::size_t object : view_ ? world().surfaces() : std::span<const std::size_t>()) {
    const Surface& surface = *world().objects()[object].surface;
    if (!counted.insert(&surface).second) continue;
    s.bricks_resident += surface.residency().size();
    s.bytes_read += surface.producer()->bytes_read();
    times.reading_milliseconds += surface.producer()->times().reading_milliseconds;
    times.decoding_milliseconds += surface.producer()->times().decoding_milliseconds;
  }
  s.bricks_produced = client_->bricks_made;
  s.bricks_evicted = client_->bricks_evicted;
  turn.end();
  s.samples = totals.samples;
  s.converged = converged();
  const double wanted = static_cast<double>(std::max<std::uint64_t>(totals.wanted, 1));
  s.resident_share = s.converged ? 1.0 : static_cast<double>(totals.resident) / wanted;
  if (surfaces_ && !surfaces_->complete()) {
    // Of bricks that are drawn, and elements that are missing.
    const auto drawn = static_cast<double>(surfaces_->counts().drawn());
    const double share = drawn / std::max(drawn + static_cast<double>(lacking_of_surfaces_.size()), 1.0);
    s.resident_share = has_volumes() ? std::min(s.resident_share, share) : share;
  }
  s.worst_lack = s.converged ? 0 : totals.worst_lack;
  s.peak_memory_bytes = peak_memory_bytes();
  s.stages = {.reading = times.reading_milliseconds,
              .decoding = times.decoding_milliseconds,
              .producing = cache_->making_milliseconds(),
              .marching = marching_.milliseconds(),
              .committing = committing_.milliseconds(),
              .waiting = waiting_.milliseconds()};
  return s;
}

exec::Device Viewer::host() const {
  return cache_->device().kind() == exec::DeviceKind::cpu ? cache_->device() : exec::Device::cpu();
}

render::Film::Development Viewer::development() const {
  return {view_->antialias, view_->background, view_->opaque_background};
}

render::Picture Viewer::picture() const {
  if (!film_) return {};
  return film_->develop(host(), development());
}

Status Viewer::picture(const render::PictureTarget& target) {
  if (!film_) return kNoView;
  GVX_TRY(render::check(target, view_->width, view_->height));
  const bool wants_reach = !target.depth.values.empty() || !target.object.values.empty();
  const bool deep =
      world().objects().size() > 1 || !has_volumes() || !scene::projects(world().objects()[0].shown.mode);
  if (wants_reach && !deep) return Error{"picture: depth: only modes composite and isosurface have one"};
  film_->develop(host(), development(), target);
  if (wants_reach) write_reach(target);
  return {};
}

void Viewer::write_reach(const render::PictureTarget& target) {
  constexpr float kHalf = 0.5f;
  const exec::FairMutex::Turn turn = cache_->take_turn();
  const std::uint32_t width = view_->width, rays = view_->antialias;
  const WorldFrames& frames = shown_frames();
  const render::Pass all = pass(frames);
  const scene::CameraView& camera = all.film.camera;
  const auto put = [&](const auto& rows, std::size_t x, std::size_t y, auto value) {
    if (!rows.values.empty()) rows.values[y * (rows.stride > 0 ? rows.stride : width) + x] = value;
  };
  exec::parallel_for(host(), view_->height, [&](std::size_t y) {
    for (std::uint32_t x = 0; x < width; ++x) {
      double along_view = INFINITY;
      std::int32_t object = -1;
      if (film_->opacity(rays, x, static_cast<std::uint32_t>(y)) >= kHalf) {
        const auto middle = [&](double pixel) { return pixel * rays + 0.5 * (rays - 1); };
        const double ray_x = middle(x), ray_y = middle(static_cast<double>(y));
        const render::RayReach reach = render::reach(all, ray_x, ray_y, kHalf);
        along_view = reach.distance * dot(camera.pixel_ray_from_eye(ray_x, ray_y).direction, camera.forward);
        if (reach.object == render::RayReach::kSurface) {
          object =
              all.surfaces.at(static_cast<std::uint32_t>(ray_x), static_cast<std::uint32_t>(ray_y)).object;
        } else if (reach.object >= 0) {
          object = static_cast<std::int32_t>(frames.object(static_cast<std::size_t>(reach.object)));
        }
      }
      put(target.depth, x, y, static_cast<float>(along_view));
      put(target.object, x, y, object);
    }
  });
}

}  // namespace gvx::engine
