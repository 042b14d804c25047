#include "gvx/render/tile/scene_tile.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "gvx/render/reference/object_ray.h"
#include "gvx/render/reference/stretch.h"

namespace gvx::render {
namespace {

// Rays of fewer pixels are marched by themselves: to set out a tile's rays for vectors takes longer.
constexpr std::int64_t kFewestInVectors = 48;

FilmRect film_rect_of(const RaysOfTile& rays) {
  const auto last = [&](double first, std::uint32_t count) {
    return static_cast<std::int32_t>(first + rays.apart * (count - 1));
  };
  return {static_cast<std::int32_t>(rays.x0), last(rays.x0, rays.width), static_cast<std::int32_t>(rays.y0),
          last(rays.y0, rays.height)};
}

/// How many rays of a tile are in a rectangle, about.
std::int64_t rays_in(const FilmRect& rect, const FilmRect& tile, double apart) {
  const double width = std::min(rect.x1, tile.x1) - std::max(rect.x0, tile.x0) + 1;
  const double height = std::min(rect.y1, tile.y1) - std::max(rect.y0, tile.y0) + 1;
  return static_cast<std::int64_t>(width * height / (apart * apart));
}

}  // namespace

SceneTile::SceneTile(const Pass& pass, const ObjectTiles& objects, const RaysOfTile& rays,
                     const ActiveRays& marching)
    : pass_(pass), rays_(rays), marching_(marching) {
  const FilmRect tile = film_rect_of(rays);
  for (const std::uint32_t index : objects.objects_in(tile)) {
    const FilmRect& rect = objects.rect_of(index);
    marches_.push_back(march_of(pass.objects[index], pass.number));
    const bool projects = marches_.back()->projects();
    const bool many = rays_in(rect, tile, rays.apart) >= kFewestInVectors;
    objects_.push_back({&pass.objects[index], rect, many && !pass.one_ray_at_a_time, projects});
    projecting_ += projects ? 1 : 0;
  }
  if (!pass.surfaces.empty()) {
    auto surface = std::make_unique<SurfaceHit>();
    surface_ = surface.get();
    marches_.push_back(std::move(surface));
    objects_.push_back({nullptr, tile, false, false});
  }
  put_spans(marching);
  by_distance_.resize(objects_.size());
  std::iota(by_distance_.begin(), by_distance_.end(), 0u);
  std::stable_sort(by_distance_.begin(), by_distance_.end(), [&](std::uint32_t a, std::uint32_t b) {
    return objects_[a].nearest < objects_[b].nearest;
  });
}

void SceneTile::put_spans(const ActiveRays& marching) {
  first_.assign(TileRays::kMost + 1, 0);
  for (std::uint32_t ray = 0; ray < TileRays::kMost; ++ray) {
    first_[ray] = static_cast<std::uint32_t>(spans_.size());
    if (!marching.has(ray)) continue;
    const double x = x_of(ray), y = y_of(ray);
    const BundleRay of_film = ray_of(ray);
    if (surface_ != nullptr) put_surface(ray);
    for (std::uint32_t i = 0; i < objects_.size(); ++i) {
      Object& object = objects_[i];
      if (object.view == nullptr) {
        if (surface_->seen()) spans_.push_back(surface_->span(i));
        continue;
      }
      if (!(x >= object.rect.x0 && x <= object.rect.x1 && y >= object.rect.y0 && y <= object.rect.y1))
        continue;
      const ObjectRay through(object.view->frame, of_film);
      if (through.inside.empty()) continue;
      const RaySpan span(object.view->frame, through, i);
      if (surface_ != nullptr && span.enter >= surface_->distance()) continue;
      spans_.push_back(span);
      object.nearest = std::min(object.nearest, span.enter);
    }
    sort_spans(std::span(spans_).subspan(first_[ray]));
  }
  first_[TileRays::kMost] = static_cast<std::uint32_t>(spans_.size());
}

void SceneTile::march(RayState* states, PreviewPixel* pixels, exec::Deadline deadline) {
  states_ = states;
  pixels_ = pixels;
  deadline_ = deadline;
  marching_.for_each([&](std::uint32_t ray) { go_on(ray); });
  for (bool some = true; some;) {
    some = false;
    for (const std::uint32_t index : by_distance_) {
      if (objects_[index].waiting.count() == 0) continue;
      march_waiting(index);
      some = true;
      if (exec::late(deadline_)) return;
    }
  }
}

/// Is it too late to begin another segment? Some are begun however late it is.
bool SceneTile::has_late_ray() {
  constexpr int kLeastSegments = 64;
  return ++begun_ > kLeastSegments && exec::late(deadline_);
}

/// A ray goes on until it lacks data, is finished, or stands before an object that it is to go through
/// together with others.
void SceneTile::go_on(std::uint32_t ray) {
  RayState& state = states_[ray];
  const auto spans = std::span<const RaySpan>(spans_).subspan(first_[ray], first_[ray + 1] - first_[ray]);
  if (spans.empty()) state.phase = RayPhase::finished;
  while (state.phase == RayPhase::under_way) {
    Object& object = objects_[spans[state.segment].object];
    if (object.in_vectors && segment_end(spans, state.segment) == state.segment + 1) {
      return object.waiting.set(ray);
    }
    if (has_late_ray()) return;
    if (surface_ != nullptr) put_surface(ray);
    RayThroughObjects through{ray_of(ray), spans, marches_};
    put_projection(ray, through);
    PreviewPixel* const pixel = pixels_ != nullptr ? &pixels_[ray] : nullptr;
    if (!march_segment(through, state, pixel)) return;
  }
}

/// Where the ray keeps what projections show. A preview's ray does not stop within a segment.
void SceneTile::put_projection(std::uint32_t ray, RayThroughObjects& through) {
  if (projecting_ == 0) return;
  if (pixels_ != nullptr) {
    projection_ = {};
    samples_.resize(projecting_);
    through.projection = &projection_;
    through.samples = samples_;
    return;
  }
  const ProjectionsView& film = pass_.projections;
  GVX_CHECK(projecting_ <= film.objects);
  const std::size_t index =
      pass_.film.index(static_cast<std::uint32_t>(x_of(ray)), static_cast<std::uint32_t>(y_of(ray)));
  RayProjection& projection = film.rays[index];
  if (projection.epoch != pass_.epoch) projection = {.epoch = pass_.epoch};
  through.projection = &projection;
  through.samples = {&film.samples[index * film.objects], film.objects};
}

void SceneTile::march_waiting(std::uint32_t index) {
  Object& object = objects_[index];
  const ActiveRays rays = object.waiting;
  object.waiting = {};
  if (object.projects) {
    project(index, rays);
  } else {
    march_object(pass_, *object.view, rays_, rays, states_, pixels_, deadline_);
  }
  rays.for_each([&](std::uint32_t ray) {
    if (states_[ray].phase != RayPhase::finished) return;
    enter_segment(states_[ray], std::size_t{states_[ray].segment} + 1, first_[ray + 1] - first_[ray]);
    go_on(ray);
  });
}

/// Rays go through an object that projects, beside which there is no other: what it shows is put behind what
/// they have gathered.
void SceneTile::project(std::uint32_t index, const ActiveRays& rays) {
  gathering_.assign(TileRays::kMost, RayState{});
  const auto place_of = [&](std::uint32_t ray) {
    RayThroughObjects place{{}, {}, marches_};
    put_projection(ray, place);
    return place.projection;
  };
  rays.for_each([&](std::uint32_t ray) { gathering_[ray] = place_of(ray)->gathering; });
  const ActiveRays stubs =
      march_object(pass_, *objects_[index].view, rays_, rays, gathering_.data(), pixels_, deadline_);
  rays.for_each([&](std::uint32_t ray) {
    RayProjection& projection = *place_of(ray);
    projection.gathering = gathering_[ray];
    RayState& gathered = projection.gathering;
    if (stubs.has(ray)) {
      marches_[index]->begin(ray_of(ray));
      marches_[index]->march_projection(gathered, projection.found,
                                        pixels_ != nullptr ? &pixels_[ray] : nullptr);
    }
    if (gathered.phase != RayPhase::finished) return;
    RayState& state = states_[ray];
    state.samples += gathered.samples;
    if (gathered.opacity > 0.0f) add(state, gathered.color / gathered.opacity, gathered.opacity);
    state.phase = RayPhase::finished;
    projection = {.epoch = projection.epoch};
  });
}

}  // namespace gvx::render
