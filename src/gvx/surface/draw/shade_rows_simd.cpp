// shade_row: surface_shading.h with a pixel in each lane. Compiled once for each instruction set.

#include "gvx/surface/draw/simd_targets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "gvx/surface/draw/shade_rows_simd.cpp"
// The order matters.
// clang-format off
#include <hwy/foreach_target.h>
#include <hwy/contrib/math/math-inl.h>
#include <hwy/highway.h>
#include "gvx/surface/draw/lanes_simd-inl.h"
// clang-format on

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "gvx/surface/draw/shade_rows.h"

HWY_BEFORE_NAMESPACE();
namespace gvx::surface::HWY_NAMESPACE {
namespace {

constexpr std::size_t kMost = hn::MaxLanes(kFloats);

struct Vec3v {
  Float x, y, z;
};
HWY_INLINE Vec3v all_of(const Vec3f& v) {
  return {all(v.x), all(v.y), all(v.z)};
}
HWY_INLINE Float dot(const Vec3v& a, const Vec3v& b) {
  return hn::MulAdd(a.x, b.x, hn::MulAdd(a.y, b.y, hn::Mul(a.z, b.z)));
}
HWY_INLINE Vec3v scaled(Float s, const Vec3v& v) {
  return {hn::Mul(s, v.x), hn::Mul(s, v.y), hn::Mul(s, v.z)};
}
HWY_INLINE Vec3v sum(const Vec3v& a, const Vec3v& b) {
  return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)};
}
HWY_INLINE Vec3v difference(const Vec3v& a, const Vec3v& b) {
  return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}
HWY_INLINE Vec3v chosen(Mask mask, const Vec3v& a, const Vec3v& b) {
  return {hn::IfThenElse(mask, a.x, b.x), hn::IfThenElse(mask, a.y, b.y), hn::IfThenElse(mask, a.z, b.z)};
}
HWY_INLINE Vec3v unit_or_zero(const Vec3v& v) {
  const Float length2 = dot(v, v);
  const Mask some = hn::Gt(length2, hn::Zero(kFloats));
  return scaled(hn::IfThenElseZero(some, hn::Div(all(1), hn::Sqrt(hn::IfThenElse(some, length2, all(1))))),
                v);
}

/// Three numbers of each lane, in memory.
struct Stored3 {
  alignas(64) float x[kMost], y[kMost], z[kMost];

  HWY_INLINE Vec3v load() const { return {hn::Load(kFloats, x), hn::Load(kFloats, y), hn::Load(kFloats, z)}; }
  void put(std::size_t lane, const Vec3f& v) { x[lane] = v.x, y[lane] = v.y, z[lane] = v.z; }
};

/// What is gathered of some pixels of a row, a lane each.
struct Gathered {
  Stored3 normal;                          // in cells; of triangles. Of samples:
  alignas(64) std::int32_t packed[kMost];  // octahedral
  Stored3 color;                           // 0 to 255
  Stored3 middle;                          // of a sample's cell, in camera space
  alignas(64) float depth[kMost];  // of the surface, of triangles; of samples that of the cell's middle
  alignas(64) float reach[kMost];  // how far from there a sample's may be; 0 of triangles
  alignas(64) std::int32_t instance[kMost];
  std::uint32_t x[kMost];
  std::int32_t object[kMost];
  std::size_t count = 0;
};

class RowShader {
 public:
  RowShader(const RowShading& shading, SurfacePixel* row, std::uint32_t y)
      : shading_(shading), row_(row), y_(y) {
    const float exponent = shading.lighting.shininess;
    constexpr float kMostMultiplied = 256;
    whole_exponent_ = exponent == std::floor(exponent) && exponent <= kMostMultiplied;
  }

  void shade(std::uint32_t x0, std::uint32_t x1) {
    Gathered gathered;
    const std::size_t lanes = hn::Lanes(kFloats);
    for (std::uint32_t x = x0; x < x1; ++x) {
      const SurfacePixel& pixel = row_[x];
      if (!pixel.seen() || pixel.shaded()) continue;
      const SeenBrick& brick = shading_.bricks[pixel.brick];
      if (!brick.there) continue;
      gather(pixel, brick, x, gathered);
      if (gathered.count == lanes) finish(gathered);
    }
    if (gathered.count > 0) finish(gathered);
  }

 private:
  void gather(const SurfacePixel& pixel, const SeenBrick& brick, std::uint32_t x, Gathered& to) const {
    const std::size_t lane = to.count++;
    to.x[lane] = x;
    to.object[lane] = brick.object;
    to.instance[lane] = static_cast<std::int32_t>(brick.instance);
    if (brick.by_triangles) {
      gather_triangle(pixel, brick, x, lane, to);
    } else {
      gather_sample(pixel, brick, lane, to);
    }
    if (shading_.overlay == Overlay::none) return;
    to.color.put(lane, 255.0f * overlay_color(shading_.overlay, brick, pixel.item));
  }

  static void gather_sample(const SurfacePixel& pixel, const SeenBrick& brick, std::size_t lane,
                            Gathered& to) {
    const Cell cell = unpacked(pixel.item);
    const Cell grid = GridAxes(brick.samples.axis).to_grid(cell);
    const SampleAttributes& a = brick.samples.attributes[brick.samples.grid.rank(grid.x, grid.y, grid.z)];
    to.packed[lane] = a.normal[0] | a.normal[1] << 8 | a.normal[2] << 16;
    to.color.put(lane, {float(a.color[0]), float(a.color[1]), float(a.color[2])});
    const float u = static_cast<float>(cell.x) + 0.5f, v = static_cast<float>(cell.y) + 0.5f,
                w = static_cast<float>(cell.z) + 0.5f;
    to.middle.put(lane, brick.corner + u * brick.cell[0] + v * brick.cell[1] + w * brick.cell[2]);
    to.depth[lane] = pixel.depth;
    to.reach[lane] =
        0.5f * (std::fabs(brick.cell[0].z) + std::fabs(brick.cell[1].z) + std::fabs(brick.cell[2].z));
  }

  /// Corners are told from where the ray meets the triangle: floats suffice for what is so near.
  void gather_triangle(const SurfacePixel& pixel, const SeenBrick& brick, std::uint32_t x, std::size_t lane,
                       Gathered& to) const {
    const Ray ray = shading_.film.ray(x, y_);
    const Vec3f at(ray.at(pixel.depth));
    Vec3f from[3];
    std::uint32_t vertex[3];
    for (int i = 0; i < 3; ++i) {
      vertex[i] = brick.triangles.vertex(pixel.item, i);
      const Vec3f parts = Vec3f(brick.triangles.place(vertex[i])) * (1.0f / kCellParts);
      from[i] =
          brick.corner - at + (parts.x * brick.cell[0] + parts.y * brick.cell[1] + parts.z * brick.cell[2]);
    }
    const Vec3f normal = cross(from[1] - from[0], from[2] - from[0]);
    const float area2 = gvx::dot(normal, normal);
    float weight[3] = {1.0f / 3, 1.0f / 3, 1.0f / 3};
    if (area2 > 0) {
      for (int i = 0; i < 3; ++i) {
        const float share = gvx::dot(cross(from[(i + 1) % 3], from[(i + 2) % 3]), normal) / area2;
        weight[i] = std::fmin(std::fmax(share, 0.0f), 1.0f);
      }
    }
    Vec3f mixed_normal, mixed_color;
    Vec3f first;
    for (int i = 0; i < 3; ++i) {
      const SampleAttributes a = brick.triangles.attributes(vertex[i]);
      const Vec3f n = normal_of(a);
      if (i == 0) first = n;
      mixed_normal = mixed_normal + weight[i] * n;
      mixed_color = mixed_color + weight[i] * Vec3f(float(a.color[0]), float(a.color[1]), float(a.color[2]));
    }
    constexpr float kLeast = 1e-6f;
    to.normal.put(lane, gvx::dot(mixed_normal, mixed_normal) > kLeast ? mixed_normal : first);
    to.color.put(lane, mixed_color);
    to.packed[lane] = -1;
    to.middle.put(lane, at);
    to.depth[lane] = pixel.depth;
    to.reach[lane] = 0;
  }

  /// sample_attributes.h: normal_of().
  static HWY_INLINE Vec3v unpacked_normal(Int packed) {
    const auto unit = [](Int bits) HWY_ATTR {
      return hn::MulSub(hn::ConvertTo(kFloats, hn::And(bits, hn::Set(kInts, 4095))), all(2.0f / 4095),
                        all(1));
    };
    Float x = unit(hn::ShiftRight<12>(packed)), y = unit(packed);
    const Float z = hn::Sub(hn::Sub(all(1), hn::Abs(x)), hn::Abs(y));
    const Mask folded = hn::Lt(z, hn::Zero(kFloats));
    const Float unfolded_x = hn::CopySign(hn::Sub(all(1), hn::Abs(y)), x);
    const Float unfolded_y = hn::CopySign(hn::Sub(all(1), hn::Abs(x)), y);
    x = hn::IfThenElse(folded, unfolded_x, x);
    y = hn::IfThenElse(folded, unfolded_y, y);
    return {x, y, z};
  }

  HWY_INLINE Float shine(Float base) const {
    const float exponent = shading_.lighting.shininess;
    if (!whole_exponent_) {
      constexpr float kLeast = 1e-30f;  // the logarithm of nothing would be none
      return hn::Exp(kFloats, hn::Mul(all(exponent), hn::Log(kFloats, hn::Max(base, all(kLeast)))));
    }
    Float power = all(1);
    for (auto left = static_cast<unsigned>(exponent); left != 0; left /= 2) {
      if (left % 2 != 0) power = hn::Mul(power, base);
      base = hn::Mul(base, base);
    }
    return power;
  }

  /// Normals of camera space.
  HWY_INLINE Vec3v to_camera(const Gathered& g, const Vec3v& normal) const {
    const Int instance = hn::Load(kInts, g.instance);
    Vec3v turned = normal;
    for (std::size_t lane = 0; lane < g.count; ++lane) {
      if (lane > 0 && g.instance[lane] == g.instance[lane - 1]) continue;
      const NormalsToCamera& n = shading_.normals[static_cast<std::size_t>(g.instance[lane])];
      const Vec3v here{dot(all_of(n.row[0]), normal), dot(all_of(n.row[1]), normal),
                       dot(all_of(n.row[2]), normal)};
      const Mask same = hn::RebindMask(kFloats, hn::Eq(instance, hn::Set(kInts, g.instance[lane])));
      turned = chosen(same, here, turned);
    }
    return unit_or_zero(turned);
  }

  void finish(Gathered& g) const {
    for (std::size_t lane = g.count; lane < kMost; ++lane) {
      // What no pixel is in is like the first.
      g.packed[lane] = g.packed[0], g.instance[lane] = g.instance[0], g.x[lane] = g.x[0];
      g.normal.put(lane, {0, 0, 1}), g.color.put(lane, {}), g.middle.put(lane, {0, 0, 1});
      g.depth[lane] = g.depth[0], g.reach[lane] = 0;
    }
    const Int packed = hn::Load(kInts, g.packed);
    const Mask is_sample = hn::RebindMask(kFloats, hn::Gt(packed, hn::Set(kInts, -1)));
    const Vec3v normal = to_camera(g, chosen(is_sample, unpacked_normal(packed), g.normal.load()));

    alignas(64) float x_of[kMost];
    for (std::size_t lane = 0; lane < kMost; ++lane) x_of[lane] = static_cast<float>(g.x[lane]);
    const FilmPlane& film = shading_.film;
    const auto pixel = static_cast<float>(film.pixel);
    const Float across =
        hn::Mul(hn::Sub(hn::Load(kFloats, x_of), all(static_cast<float>(film.half_width - 0.5))), all(pixel));
    const Float up = all(static_cast<float>((film.half_height - 0.5 - double(y_)) * film.pixel));
    const Float zero = hn::Zero(kFloats), one = all(1);
    const Vec3v origin = film.orthographic ? Vec3v{across, up, zero} : Vec3v{zero, zero, zero};
    const Vec3v way = film.orthographic ? Vec3v{zero, zero, one} : Vec3v{across, up, one};

    // A sample lies on the plane through the middle of its cell.
    const Float depth = hn::Load(kFloats, g.depth), reach = hn::Load(kFloats, g.reach);
    const Float slope = dot(normal, way);
    const Float meets = hn::Div(dot(normal, difference(g.middle.load(), origin)), slope);
    const Float held = hn::Min(hn::Max(meets, hn::Sub(depth, reach)), hn::Add(depth, reach));
    const Mask usable = hn::And(is_sample, hn::Ne(slope, zero));
    const Float place = hn::IfThenElse(usable, held, depth);

    const Vec3v base = scaled(all(1.0f / 255), g.color.load());
    const Vec3v shown =
        lit(base, normal, unit_or_zero(scaled(all(-1), way)), sum(origin, scaled(place, way)));
    Stored3 colors;
    alignas(64) float places[kMost];
    hn::Store(shown.x, kFloats, colors.x);
    hn::Store(shown.y, kFloats, colors.y);
    hn::Store(shown.z, kFloats, colors.z);
    hn::Store(place, kFloats, places);
    for (std::size_t lane = 0; lane < g.count; ++lane) {
      SurfacePixel& out = row_[g.x[lane]];
      out.place = places[lane];
      out.color = {colors.x[lane], colors.y[lane], colors.z[lane]};
      out.object = g.object[lane];
    }
    g.count = 0;
  }

  /// scene::LightingView::shade of what is certainly a surface.
  HWY_INLINE Vec3v lit(const Vec3v& base, const Vec3v& normal, const Vec3v& to_eye,
                       const Vec3v& point) const {
    const scene::Lighting& lighting = shading_.lighting;
    if (!lighting.enabled) return base;
    Vec3v body{all(lighting.ambient), all(lighting.ambient), all(lighting.ambient)};
    Vec3v glints = all_of({});
    for (int i = 0; i < lighting.lights; ++i) {
      const scene::Light& light = lighting.light[i];
      Vec3v to_light = all_of(shading_.light[i]);
      if (light.kind == scene::LightKind::point) to_light = unit_or_zero(difference(to_light, point));
      const Float facing = hn::Mul(all(lighting.diffuse), hn::Abs(dot(normal, to_light)));
      const Float half_way = hn::Abs(dot(normal, unit_or_zero(sum(to_eye, to_light))));
      const Float glint = hn::Mul(all(lighting.specular), shine(half_way));
      const Vec3v color = all_of(light.color);
      body = sum(body, scaled(facing, color));
      glints = sum(glints, scaled(glint, color));
    }
    return {hn::MulAdd(base.x, body.x, glints.x), hn::MulAdd(base.y, body.y, glints.y),
            hn::MulAdd(base.z, body.z, glints.z)};
  }

  const RowShading& shading_;
  SurfacePixel* row_;
  std::uint32_t y_;
  bool whole_exponent_;
};

}  // namespace

void shade_row(const RowShading& shading, SurfacePixel* row, std::uint32_t y, std::uint32_t x0,
               std::uint32_t x1) {
  RowShader(shading, row, y).shade(x0, x1);
}

}  // namespace gvx::surface::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace gvx::surface {

HWY_EXPORT(shade_row);

void shade_row(const RowShading& shading, SurfacePixel* row, std::uint32_t y, std::uint32_t x0,
               std::uint32_t x1) {
  HWY_DYNAMIC_DISPATCH(shade_row)(shading, row, y, x0, x1);
}

NormalsToCamera::NormalsToCamera(const Affine3& cells_to_camera) {
  // The inverse, transposed.
  const Affine3 back = inverse(cells_to_camera);
  const double scale = 1 / length(back.column[0]);
  for (int i = 0; i < 3; ++i) row[i] = Vec3f(back.column[i] * scale);
}

Vec3f overlay_color(Overlay overlay, const SeenBrick& brick, std::uint32_t item) {
  constexpr Vec3f kRed(0.85f, 0.25f, 0.2f), kGreen(0.3f, 0.7f, 0.3f), kBlue(0.25f, 0.45f, 0.85f);
  if (overlay == Overlay::technique) {
    return brick.by_triangles ? kRed : brick.technique == Technique::cast ? kGreen : kBlue;
  }
  // As in figure 7 of Reichl and others: one sample, one span of several, several spans.
  if (brick.by_triangles) return Vec3f(0.6f);
  const Cell cell = GridAxes(brick.samples.axis).to_grid(unpacked(item));
  const std::uint32_t column = brick.samples.grid.column(cell.x, cell.y), low = column & (~column + 1);
  if (bits_in(column) == 1) return kGreen;
  const bool one_span = (column & (column + low)) == 0;
  return one_span ? kBlue : kRed;
}

}  // namespace gvx::surface
#endif
