#include "gvx/render/tile_march.h"

#include <array>
#include <atomic>
#include <memory>
#include <vector>

#include "gvx/core/result.h"
#include "gvx/exec/parallel.h"
#include "gvx/render/march.h"
#include "gvx/render/march_view.h"
#include "gvx/render/stretch_batch.h"

namespace gvx::render {
namespace {

bool late(exec::Deadline deadline) {
  return deadline != exec::no_deadline() && std::chrono::steady_clock::now() >= deadline;
}

template <typename Voxel, int N, int M>
class TileMarcher {
 public:
  explicit TileMarcher(const PassView<Voxel, N, M>& view) : view_(view) {
    batch_.m = M;
    rays_.reserve(StretchBatch::kMost);
  }

  void add(std::uint32_t x, std::uint32_t y, RayState& state) {
    rays_.push_back({{view_, double(x), double(y)}, &state, {}});
    advance(static_cast<std::uint32_t>(rays_.size() - 1));
  }

  /// Marches until no ray has anything to go through, or the deadline, at which rays step back before what
  /// they were to go through.
  void march(exec::Deadline deadline) {
    // Stepping back costs the way to the brick again: a tile that was begun comes a good part further.
    constexpr int kLeastBatches = 32;
    for (int batches = 0; !waiting_.empty() && (batches < kLeastBatches || !late(deadline)); ++batches) {
      gather_nearest();
      composite_batch(view_.frame, batch_);
      take_back();
    }
    for (const Waiting& waiting : waiting_) {
      const TileRay& ray = rays_[waiting.ray];
      ray.state->tick -= ray.stretch.steps * view_.frame.stride[ray.stretch.level];
    }
    waiting_.clear();
  }

 private:
  struct TileRay {
    RayMarcher<Voxel, N, M> marcher;
    RayState* state;
    Stretch<Voxel, M> stretch;
  };

  /// A ray before its next stretch: what the order of bricks is made of, close together.
  struct Waiting {
    float t;
    std::uint32_t ray;
    const Voxel* brick;
    int level;
    bool blended, deviates;

    bool goes_with(const Waiting& other) const {
      return brick == other.brick && level == other.level && blended == other.blended &&
             deviates == other.deviates;
    }
  };

  /// To the ray's next stretch, if it has one.
  void advance(std::uint32_t index) {
    TileRay& ray = rays_[index];
    if (!ray.marcher.next_stretch(*ray.state, ray.stretch)) return;
    const Stretch<Voxel, M>& s = ray.stretch;
    waiting_.push_back(
        {static_cast<float>(s.t_centre), index, s.fine.brick.voxels, s.level, s.blended, s.fine_deviates});
  }

  /// Puts all rays before the brick that is nearest to one of them into the batch.
  void gather_nearest() {
    Waiting nearest = waiting_.front();
    for (const Waiting& waiting : waiting_) {
      if (waiting.t < nearest.t) nearest = waiting;
    }
    const Stretch<Voxel, M>& chosen = rays_[nearest.ray].stretch;
    const FrameView& frame = view_.frame;
    batch_.units = frame.units_per_tick * static_cast<float>(frame.stride[chosen.level]);
    batch_.blended = chosen.blended;
    batch_.fine.brick = reinterpret_cast<const std::byte*>(chosen.fine.brick.voxels);
    batch_.fine.deviates = chosen.fine_deviates;
    batch_.fine.gradient_scale = frame.gradient_scale[chosen.level];
    if (chosen.blended) {
      batch_.coarse.brick = reinterpret_cast<const std::byte*>(chosen.coarse.brick.voxels);
      batch_.coarse.deviates = true;
      batch_.coarse.gradient_scale = frame.gradient_scale[chosen.level - 1];
    }
    batch_.count = 0;
    chosen_.clear();
    std::size_t others = 0;
    for (const Waiting& waiting : waiting_) {
      if (waiting.goes_with(nearest)) {
        chosen_.push_back(waiting.ray);
      } else {
        waiting_[others++] = waiting;
      }
    }
    waiting_.resize(others);
    order_by_steps();
    for (const std::uint32_t ray : chosen_) put(rays_[ray], batch_.count++);
  }

  /// Rays of a vector go as far as the one that goes farthest: those that go as far are put together.
  void order_by_steps() {
    constexpr std::int64_t kLengths = 128;
    const auto length_of = [&](std::uint32_t ray) {
      const std::int64_t steps = rays_[ray].stretch.steps;
      return static_cast<std::size_t>(steps < kLengths ? steps : kLengths - 1);
    };
    std::array<std::uint16_t, kLengths + 1> first{};
    for (const std::uint32_t ray : chosen_) ++first[length_of(ray) + 1];
    for (std::size_t i = 1; i < first.size(); ++i)
      first[i] = static_cast<std::uint16_t>(first[i] + first[i - 1]);
    ordered_.resize(chosen_.size());
    for (const std::uint32_t ray : chosen_) ordered_[first[length_of(ray)]++] = ray;
    chosen_.swap(ordered_);
  }

  void put(const TileRay& ray, std::size_t lane) {
    const Stretch<Voxel, M>& s = ray.stretch;
    const FrameView& frame = view_.frame;
    for (int axis = 0; axis < 3; ++axis) {
      batch_.fine.first[axis][lane] = s.fine.first[axis];
      batch_.fine.per_step[axis][lane] = s.fine.per_step[axis];
      batch_.color[axis][lane] = ray.state->color[axis];
    }
    batch_.steps[lane] = static_cast<std::int32_t>(s.steps);
    batch_.opacity[lane] = ray.state->opacity;
    batch_.samples[lane] = static_cast<std::int32_t>(ray.state->samples);
    if (s.blended) {
      for (int axis = 0; axis < 3; ++axis) {
        batch_.coarse.first[axis][lane] = s.coarse.first[axis];
        batch_.coarse.per_step[axis][lane] = s.coarse.per_step[axis];
      }
      const double now = frame.share_at(s.level, s.t_at(0)), next = frame.share_at(s.level, s.t_at(1));
      batch_.blend[lane] = static_cast<float>(now);
      batch_.blend_per_step[lane] = static_cast<float>(next - now);
    }
    if (!frame.lighting.lighting.enabled) return;
    const Ray& world = ray.marcher.ray_world();
    const Vec3d place = world.at(s.t_centre);
    for (int axis = 0; axis < 3; ++axis) {
      batch_.to_eye[axis][lane] = static_cast<float>(-world.direction[axis]);
      batch_.place[axis][lane] = static_cast<float>(place[axis]);
      batch_.place_per_step[axis][lane] = static_cast<float>(world.direction[axis] * s.t_step);
    }
  }

  /// Gives the rays of the batch what it gathered; they wait for their next stretch, or leave.
  void take_back() {
    for (std::size_t lane = 0; lane < chosen_.size(); ++lane) {
      TileRay& ray = rays_[chosen_[lane]];
      RayState& state = *ray.state;
      state.color = {batch_.color[0][lane], batch_.color[1][lane], batch_.color[2][lane]};
      state.opacity = batch_.opacity[lane];
      state.samples = static_cast<std::uint32_t>(batch_.samples[lane]);
      if (state.opacity >= kOpaque) state.phase = RayPhase::finished;
      advance(chosen_[lane]);
    }
  }

  const PassView<Voxel, N, M>& view_;
  std::vector<TileRay> rays_;
  std::vector<Waiting> waiting_;
  std::vector<std::uint32_t> chosen_, ordered_;  // the rays in the batch
  StretchBatch batch_;
};

template <typename Voxel, int N, int M>
bool march_tiles(const exec::Device& cpu, const PassView<Voxel, N, M>& view, const Pass& pass,
                 exec::TileGrid grid, exec::BufferView<const std::uint32_t> tiles, exec::Deadline deadline,
                 exec::BufferView<RayState> rays, exec::BufferView<std::uint32_t> unfinished) {
  GVX_CHECK(grid.tile * grid.tile <= StretchBatch::kMost);
  std::atomic<bool> all_begun{true};
  exec::parallel_for(cpu, tiles.size, [&](std::size_t t) {
    if (late(deadline)) {
      all_begun.store(false, std::memory_order_relaxed);
      return;
    }
    const std::uint32_t x0 = tiles[t] % grid.tiles_x() * grid.tile;
    const std::uint32_t y0 = tiles[t] / grid.tiles_x() * grid.tile;
    const auto for_rays = [&](auto function) {
      for (std::uint32_t y = y0; y < y0 + grid.tile && y < grid.height; ++y) {
        for (std::uint32_t x = x0; x < x0 + grid.tile && x < grid.width; ++x) {
          function(x, y, rays[std::size_t(y) * grid.width + x]);
        }
      }
    };
    // Made where a ray needs it: a tile that is finished must cost next to nothing, or short frames end in
    // it.
    std::unique_ptr<TileMarcher<Voxel, N, M>> marcher;
    for_rays([&](std::uint32_t x, std::uint32_t y, RayState& ray) {
      if (ray.epoch != pass.epoch) {
        ray = RayState{};
        ray.epoch = pass.epoch;
      }
      const std::uint64_t index = std::uint64_t(y) * grid.width + x;
      const bool runs = pass.lone_ray == Pass::kAllRays || pass.lone_ray == index;
      if (!runs || ray.phase == RayPhase::finished) return;
      if (marcher == nullptr) marcher = std::make_unique<TileMarcher<Voxel, N, M>>(view);
      marcher->add(x, y, ray);
    });
    if (marcher != nullptr) marcher->march(deadline);
    bool finished = true;
    for_rays([&](std::uint32_t, std::uint32_t, const RayState& ray) {
      finished = finished && ray.phase == RayPhase::finished;
    });
    if (!finished) exec::store_relaxed(&unfinished[tiles[t]], 1);
  });
  return all_begun.load();
}

}  // namespace

bool tile_march(const exec::Device& cpu, const Pass& pass, exec::TileGrid grid,
                exec::BufferView<const std::uint32_t> tiles, exec::Deadline deadline,
                exec::BufferView<RayState> rays, exec::BufferView<std::uint32_t> unfinished) {
  return with_voxel_type(pass.frame.format.type, [&](auto zero) {
    return with_view<decltype(zero)>(pass, [&](const auto& view) {
      return march_tiles(cpu, view, pass, grid, tiles, deadline, rays, unfinished);
    });
  });
}

}  // namespace gvx::render
