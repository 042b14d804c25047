#include "gvx/engine/seen_world.h"

#include <algorithm>
#include <atomic>
#include <utility>

#include "gvx/render/tile/object_tiles.h"

namespace gvx::engine {

Result<WorldFrames> WorldFrames::make(const exec::Device& device, const render::View& view,
                                      const World& world, const WorldFrames* previous) {
  static std::atomic<std::uint64_t> made{0};
  WorldFrames frames;
  frames.id_ = ++made;
  frames.first_of_kind_.assign(world.kinds().size(), kNone);
  GVX_ASSIGN(frames.film_, render::film_of(view));
  const std::span<const Object> objects = world.objects();
  for (std::size_t i = 0; i < objects.size(); ++i) {
    if (world.is_surface(i)) continue;
    const bool only_one_left = i + 1 == objects.size() && frames.frames_.empty() && world.surfaces().empty();
    if (!only_one_left && world.out_of_sight(i, frames.film_.camera)) continue;
    const Volume* volume = objects[i].volume.get();
    const render::Frame* like = frames.like(volume, world.kind(i));
    if (like == nullptr && previous != nullptr) like = previous->like(volume, world.kind(i));
    render::View of_object = view;
    static_cast<render::ObjectLook&>(of_object) = objects[i].shown;
    auto frame = render::Frame::make(device, of_object, world.tree(i), like);
    if (!frame.ok()) {
      if (objects.size() == 1) return frame.error();
      return Error{"objects[" + std::to_string(i) + "]: " + frame.error().message};
    }
    std::size_t& first = frames.first_of_kind_[world.kind(i)];
    if (first == kNone) first = frames.frames_.size();
    frames.frames_.push_back({i, volume, std::move(frame.value())});
  }
  return frames;
}

const render::Frame* WorldFrames::like(const Volume* volume, std::size_t kind) const {
  const auto shows_volume = [&](std::size_t first) {
    return first != kNone && frames_[first].volume == volume;
  };
  if (kind < first_of_kind_.size() && shows_volume(first_of_kind_[kind])) {
    return &frames_[first_of_kind_[kind]].frame;
  }
  const auto of_volume = std::find_if(first_of_kind_.begin(), first_of_kind_.end(), shows_volume);
  return of_volume == first_of_kind_.end() ? nullptr : &frames_[*of_volume].frame;
}

SeenWorld::SeenWorld() = default;

SeenWorld::~SeenWorld() {
  end();
}

void SeenWorld::detach(std::vector<SeenKind>& kinds) {
  for (SeenKind& kind : kinds) {
    if (kind.look != nullptr) kind.volume->residency().detach(*kind.look);
  }
  kinds.clear();
}

/// A look at an object's volume that is left: of the `same` way to see it, or of any.
std::unique_ptr<Look> SeenWorld::take(std::vector<SeenKind>& kinds, const Object& object, bool same) {
  for (SeenKind& kind : kinds) {
    const bool fits =
        kind.look != nullptr && kind.volume == object.volume && (!same || kind.shown.sees_like(object.shown));
    if (fits) return std::move(kind.look);
  }
  return nullptr;
}

void SeenWorld::see(const exec::Device& device, std::shared_ptr<const World> world,
                    const WorldFrames& frames) {
  std::vector<SeenKind> before = std::exchange(looks_, {});
  world_ = std::move(world);
  looks_.resize(world_->kinds().size());
  std::vector<const render::Frame*> frame_of(looks_.size());
  for (std::size_t i = 0; i < frames.size(); ++i) frame_of[world_->kind(frames.object(i))] = &frames.frame(i);
  for (const bool same : {true, false}) {
    for (std::size_t k = 0; k < looks_.size(); ++k) {
      if (frame_of[k] == nullptr || looks_[k].look != nullptr) continue;
      const Object& object = world_->objects()[world_->kinds()[k].object];
      Residency& residency = object.volume->residency();
      const scene::Visibility& visibility = frame_of[k]->view().visibility;
      std::unique_ptr<Look> look = take(before, object, same);
      if (same && look == nullptr) continue;
      const bool is_new = look == nullptr;
      if (is_new)
        look = std::make_unique<Look>(device, residency.nodes().tiles(), residency.bricks().slots());
      if (is_new) residency.attach(*look);
      if (same) {
        look->move_tables(visibility);
      } else {
        residency.set_visibility(*look, visibility);
      }
      looks_[k] = {object.volume, object.shown, std::move(look)};
    }
  }
  detach(before);
}

std::span<const render::ObjectView> SeenWorld::views(const WorldFrames& frames) {
  views_.resize(frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    render::ObjectView& view = views_[i];
    const std::size_t object = frames.object(i);
    Residency& residency = world_->objects()[object].volume->residency();
    Look& look = *looks_[world_->kind(object)].look;
    view.n = world_->tree(object).n;
    view.m = world_->tree(object).m;
    view.frame = frames.frame(i).view();
    view.nodes = residency.nodes().view();
    view.hidden = look.hidden();
    view.bricks = residency.bricks().bytes();
    view.tile_usage = residency.tile_usage();
    view.brick_usage = residency.brick_usage();
    view.requests = residency.requests();
    view.cells = look.cells();
  }
  return views_;
}

const render::ObjectTiles* SeenWorld::tiles(const WorldFrames& frames) {
  if (frames.size() == 1 && world_->surfaces().empty()) return nullptr;
  if (tiles_of_ != frames.id()) {
    tiles_ = std::make_unique<const render::ObjectTiles>(frames.film(), views_);
    tiles_of_ = frames.id();
  }
  return tiles_.get();
}

}  // namespace gvx::engine
