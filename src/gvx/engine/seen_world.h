/// \file
/// SeenWorld: a world as one viewer sees it: the looks at its volumes, and the frames of the objects that are
/// in sight.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "gvx/core/result.h"
#include "gvx/engine/look.h"
#include "gvx/engine/world.h"
#include "gvx/exec/device.h"
#include "gvx/render/frame/frame.h"
#include "gvx/render/march_pass.h"

namespace gvx::engine {

/// The frames of one picture of a world: one for each volume in sight, and one in any case
/// where all objects are volumes.
class WorldFrames {
 public:
  /// An error if the view cannot be made. Tables are shared with `previous`, which may be null, and among
  /// objects of a kind.
  static Result<WorldFrames> make(const exec::Device& device, const render::View& view, const World& world,
                                  const WorldFrames* previous);

  const render::FilmView& film() const { return film_; }
  std::size_t size() const { return frames_.size(); }
  const render::Frame& frame(std::size_t i) const { return frames_[i].frame; }
  /// Its object's number in the world.
  std::size_t object(std::size_t i) const { return frames_[i].object; }
  /// No other frames have the same.
  std::uint64_t id() const { return id_; }

 private:
  struct ObjectFrame {
    std::size_t object;
    const Volume* volume;
    render::Frame frame;
  };

  /// A frame whose tables may be the ones that an object needs.
  const render::Frame* like(const Volume* volume, std::size_t kind) const;

  render::FilmView film_;
  std::vector<ObjectFrame> frames_;
  static constexpr std::size_t kNone = SIZE_MAX;
  std::vector<std::size_t> first_of_kind_;  // in frames_, of each of the world's kinds; kNone: out of sight
  std::uint64_t id_ = 0;
};

/// Its looks are attached to the residencies of the volumes: whoever changes or ends it has the cache's turn.
class SeenWorld {
 public:
  SeenWorld();
  ~SeenWorld();
  SeenWorld(const SeenWorld&) = delete;
  SeenWorld& operator=(const SeenWorld&) = delete;

  /// Looks at a world's volumes as its frames say; these must live until the next call. What was looked at
  /// in the same way before is not classified anew.
  void see(const exec::Device& device, std::shared_ptr<const World> world, const WorldFrames& frames);

  /// Looks at nothing any more.
  void end() { detach(looks_); }

  /// After the first see().
  const World& world() const { return *world_; }
  const std::shared_ptr<const World>& shared_world() const { return world_; }
  bool looks_at(std::size_t object) const { return looks_[world_->kind(object)].look != nullptr; }
  /// The look at an object in sight.
  const Look& look(std::size_t object) const { return *looks_[world_->kind(object)].look; }

  /// What a pass of these frames marches; valid until the next call.
  std::span<const render::ObjectView> views(const WorldFrames& frames);
  /// Where those are on the film; null for a single volume.
  const render::ObjectTiles* tiles(const WorldFrames& frames);

 private:
  struct SeenKind {
    std::shared_ptr<Volume> volume;
    render::ObjectLook shown;
    std::unique_ptr<Look> look;  // null: none of the kind is in sight
  };

  static void detach(std::vector<SeenKind>& kinds);
  static std::unique_ptr<Look> take(std::vector<SeenKind>& kinds, const Object& object, bool same);

  std::shared_ptr<const World> world_;
  std::vector<SeenKind> looks_;  // of the world's kinds
  std::vector<render::ObjectView> views_;
  std::uint64_t tiles_of_ = 0;  // frames
  std::unique_ptr<const render::ObjectTiles> tiles_;
};

}  // namespace gvx::engine
