// rasterise_in_vectors: what rasterise() does, for many small triangles. Vertices are put on the film in
// vectors and rounded to parts of a pixel; edges are then told by whole numbers, so that no ray passes
// between triangles that share one. Compiled once for each instruction set.

#include "gvx/surface/draw/simd_targets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "gvx/surface/draw/rasterise_simd.cpp"
// The order matters.
// clang-format off
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include "gvx/surface/draw/lanes_simd-inl.h"
// clang-format on

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "gvx/surface/draw/technique_vectors.h"

HWY_BEFORE_NAMESPACE();
namespace gvx::surface::HWY_NAMESPACE {
namespace {

// Parts of a pixel that corners are rounded to.
constexpr int kPartBits = 8;
constexpr std::int32_t kParts = 1 << kPartBits;
// Corners further from the tile than this many pixels, and those behind the eye, are for the plain way:
// numbers of edges are products of two such ways, and fit 64 bits.
constexpr float kFarthest = 1 << 20;

/// The vertices of a list on the film.
struct Vertices {
  std::vector<std::int32_t> x, y;  // in parts of a pixel, from the tile's first pixel on; or kFar, kBehind
  std::vector<float> w;            // 1 / depth; orthographic: depth

  static constexpr std::int32_t kFar = INT32_MIN, kBehind = INT32_MIN + 1;

  void resize(std::size_t size) {
    if (x.size() < size) x.resize(size), y.resize(size), w.resize(size);
  }
};

class Rasteriser {
 public:
  Rasteriser(const DrawnTriangles& drawn, TileHits& hits) : drawn_(drawn), hits_(hits) {
    static thread_local Vertices vertices;
    vertices_ = &vertices;
    place_vertices();
  }

  void draw() {
    const TriangleListView& list = drawn_.triangles;
    switch (TriangleListView::corner_bytes(list.vertices)) {
      case 1:
        return draw_all<std::uint8_t>();
      case 2:
        return draw_all<std::uint16_t>();
      default:
        return draw_all<std::uint32_t>();
    }
  }

 private:
  void place_vertices() {
    const TriangleListView& list = drawn_.triangles;
    const std::size_t lanes = hn::Lanes(kFloats);
    vertices_->resize(list.vertices + lanes);
    const Affine3& to_camera = drawn_.placed.to_camera;
    const auto row = [&](int axis, float(&to)[4]) {
      for (int c = 0; c < 3; ++c) to[c] = static_cast<float>(to_camera.column[c][axis] / kCellParts);
      to[3] = static_cast<float>(to_camera.origin[axis]);
    };
    float rows[3][4];
    for (int axis = 0; axis < 3; ++axis) row(axis, rows[axis]);
    const FilmPlane& film = drawn_.film;
    const auto per_pixel = static_cast<float>(1 / film.pixel);
    const auto x0 = static_cast<float>(film.half_width - 0.5 - hits_.rect.x0),
               y0 = static_cast<float>(film.half_height - 0.5 - hits_.rect.y0);
    alignas(64) float place[3][hn::MaxLanes(kFloats)];
    for (std::size_t first = 0; first < list.vertices; first += lanes) {
      const std::size_t count = std::min<std::size_t>(lanes, list.vertices - first);
      for (std::size_t i = 0; i < lanes; ++i) {
        const Vec3<std::int32_t> p = list.place(static_cast<std::uint32_t>(first + (i < count ? i : 0)));
        place[0][i] = static_cast<float>(p.x), place[1][i] = static_cast<float>(p.y);
        place[2][i] = static_cast<float>(p.z);
      }
      const Float px = hn::Load(kFloats, place[0]), py = hn::Load(kFloats, place[1]),
                  pz = hn::Load(kFloats, place[2]);
      const auto along = [&](const float(&r)[4]) HWY_ATTR {
        return hn::MulAdd(all(r[0]), px, hn::MulAdd(all(r[1]), py, hn::MulAdd(all(r[2]), pz, all(r[3]))));
      };
      const Float z = along(rows[2]);
      const Float over_z = film.orthographic ? all(1) : hn::Div(all(1), z);
      const Float scale = hn::Mul(over_z, all(per_pixel));
      const Float x = hn::MulAdd(along(rows[0]), scale, all(x0)),
                  y = hn::NegMulAdd(along(rows[1]), scale, all(y0));
      const Mask near = hn::And(hn::Lt(hn::Abs(x), all(kFarthest)), hn::Lt(hn::Abs(y), all(kFarthest)));
      const Mask sound = hn::And(near, hn::Gt(z, hn::Zero(kFloats)));
      const Mask behind = hn::Le(z, hn::Zero(kFloats));
      const Int unsound = hn::IfThenElse(hn::RebindMask(kInts, behind), hn::Set(kInts, Vertices::kBehind),
                                         hn::Set(kInts, Vertices::kFar));
      const auto parts = [&](Float v) HWY_ATTR {
        const Int whole = hn::NearestInt(hn::IfThenElseZero(sound, hn::Mul(v, all(kParts))));
        return hn::IfThenElse(hn::RebindMask(kInts, sound), whole, unsound);
      };
      hn::StoreU(parts(x), kInts, &vertices_->x[first]);
      hn::StoreU(parts(y), kInts, &vertices_->y[first]);
      hn::StoreU(film.orthographic ? z : over_z, kFloats, &vertices_->w[first]);
    }
  }

  template <typename Corner>
  void draw_all() {
    const TriangleListView& list = drawn_.triangles;
    const std::byte* corners =
        list.bytes + list.vertices * (TriangleListView::place_bytes(list.wide) + sizeof(SampleAttributes));
    // Pixels that may be drawn into, from the tile's first on.
    const PixelRect part{drawn_.part.x0 - hits_.rect.x0, drawn_.part.y0 - hits_.rect.y0,
                         drawn_.part.x1 - hits_.rect.x0, drawn_.part.y1 - hits_.rect.y0};
    const std::int32_t* const x = vertices_->x.data();
    const std::int32_t* const y = vertices_->y.data();
    for (std::uint32_t triangle = 0; triangle < list.triangles; ++triangle) {
      Corner v[3];
      std::memcpy(v, corners + std::size_t{triangle} * sizeof(v), sizeof(v));
      const std::int32_t ax = x[v[0]], bx = x[v[1]], cx = x[v[2]], ay = y[v[0]], by = y[v[1]], cy = y[v[2]];
      const std::int32_t low_x = std::min({ax, bx, cx}), low_y = std::min({ay, by, cy});
      if (low_x <= Vertices::kBehind) {
        const bool all_behind = std::max({ax, bx, cx}) == Vertices::kBehind && low_x == Vertices::kBehind;
        if (!all_behind) draw_plainly(triangle);
        continue;
      }
      // Pixels whose middles may be covered.
      const std::int32_t x0 = std::max((low_x + kParts - 1) >> kPartBits, part.x0),
                         x1 = std::min(std::max({ax, bx, cx}) >> kPartBits, part.x1 - 1),
                         y0 = std::max((low_y + kParts - 1) >> kPartBits, part.y0),
                         y1 = std::min(std::max({ay, by, cy}) >> kPartBits, part.y1 - 1);
      if (x0 > x1 || y0 > y1) continue;
      const std::int64_t area = std::int64_t{bx - ax} * (cy - ay) - std::int64_t{cx - ax} * (by - ay);
      if (area == 0) continue;
      fill({{ax, bx, cx}, {ay, by, cy}, area}, v, {x0, y0, x1 + 1, y1 + 1}, triangle);
    }
  }

  struct Corners {
    std::int64_t x[3], y[3];
    std::int64_t area;  // twice, signed
  };

  template <typename Corner>
  HWY_INLINE void fill(const Corners& c, const Corner (&v)[3], const PixelRect& rect,
                       std::uint32_t triangle) {
    const std::int64_t side = c.area < 0 ? -1 : 1;
    std::int64_t at[3], per_x[3], per_y[3];  // weights of corners at the first pixel, and their steps
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      const std::int64_t dx = side * (c.x[k] - c.x[j]), dy = side * (c.y[k] - c.y[j]);
      const std::int64_t px = std::int64_t{rect.x0} * kParts - c.x[j],
                         py = std::int64_t{rect.y0} * kParts - c.y[j];
      at[i] = dx * py - dy * px;
      per_x[i] = -dy * kParts;
      per_y[i] = dx * kParts;
    }
    const float over_area = 1.0f / static_cast<float>(side * c.area);
    const float w0 = vertices_->w[v[0]], w1 = vertices_->w[v[1]], w2 = vertices_->w[v[2]];
    const auto nearest = static_cast<float>(drawn_.nearest);
    const float least = std::min({w0, w1, w2}), most = std::max({w0, w1, w2});
    for (std::int32_t y = rect.y0; y < rect.y1; ++y) {
      std::int64_t a = at[0], b = at[1], d = at[2];
      const std::size_t row = static_cast<std::size_t>(y) * TileHits::kEdge;
      for (std::int32_t x = rect.x0; x < rect.x1; ++x) {
        if ((a | b | d) >= 0) {
          const float mixed =
              (static_cast<float>(a) * w0 + static_cast<float>(b) * w1 + static_cast<float>(d) * w2) *
              over_area;
          const float w = std::min(std::max(mixed, least), most);
          const float depth = drawn_.film.orthographic ? w : 1 / w;
          if (depth > 0 && depth >= nearest)
            hits_.put(row + static_cast<std::size_t>(x), depth, drawn_.number, triangle);
        }
        a += per_x[0], b += per_x[1], d += per_x[2];
      }
      at[0] += per_y[0], at[1] += per_y[1], at[2] += per_y[2];
    }
  }

  void draw_plainly(std::uint32_t triangle) { rasterise_one(drawn_, triangle, hits_); }

  const DrawnTriangles& drawn_;
  TileHits& hits_;
  Vertices* vertices_;
};

}  // namespace

void rasterise_in_vectors(const DrawnTriangles& drawn, TileHits& hits) {
  Rasteriser(drawn, hits).draw();
}

}  // namespace gvx::surface::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace gvx::surface {

HWY_EXPORT(rasterise_in_vectors);

void rasterise_in_vectors(const DrawnTriangles& drawn, TileHits& hits) {
  HWY_DYNAMIC_DISPATCH(rasterise_in_vectors)(drawn, hits);
}

}  // namespace gvx::surface
#endif
