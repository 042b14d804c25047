#include "gvx/mesh/mesh_query.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>
#include <utility>

#if defined(GVX_WITH_EMBREE)
#include <embree3/rtcore.h>
#endif

namespace gvx::mesh {

#if defined(GVX_WITH_EMBREE)
namespace {

/// The weights of a triangle's corners in the point of it that is nearest to p (Ericson, "Real-Time Collision
/// Detection", 2005, 5.1.5).
std::array<float, 3> nearest_weights(Vec3f p, Vec3f a, Vec3f b, Vec3f c) {
  const Vec3f ab = b - a, ac = c - a, ap = p - a;
  const float d1 = dot(ab, ap), d2 = dot(ac, ap);
  if (d1 <= 0 && d2 <= 0) return {1, 0, 0};
  const Vec3f bp = p - b;
  const float d3 = dot(ab, bp), d4 = dot(ac, bp);
  if (d3 >= 0 && d4 <= d3) return {0, 1, 0};
  const float vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) {
    const float v = d1 / (d1 - d3);
    return {1 - v, v, 0};
  }
  const Vec3f cp = p - c;
  const float d5 = dot(ab, cp), d6 = dot(ac, cp);
  if (d6 >= 0 && d5 <= d6) return {0, 0, 1};
  const float vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) {
    const float w = d2 / (d2 - d6);
    return {1 - w, 0, w};
  }
  const float va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    const float w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {0, 1 - w, w};
  }
  const float all = va + vb + vc;
  return {va / all, vb / all, vc / all};
}

struct NearestSearch {
  const io::TriangleMesh& mesh;
  MeshQuery::Nearest best;  // at first as far as is looked, of no triangle
  bool found = false;
};

/// What is found must not depend on how triangles are shared out to boxes: boxes that are farther than the
/// best triangle by no more than rounding are looked into, too.
constexpr float kHair = 1.001f, kRounding = 1e-6f;

bool consider(RTCPointQueryFunctionArguments* arguments) {
  auto& search = *static_cast<NearestSearch*>(arguments->userPtr);
  const auto& triangle = search.mesh.triangles[arguments->primID];
  RTCPointQuery& query = *arguments->query;
  const Vec3f p(query.x, query.y, query.z);
  // From the place: there rounding is least.
  const Vec3f a = search.mesh.vertices[triangle[0]] - p, b = search.mesh.vertices[triangle[1]] - p,
              c = search.mesh.vertices[triangle[2]] - p;
  const std::array<float, 3> w = nearest_weights({}, a, b, c);
  const float distance = length(w[0] * a + w[1] * b + w[2] * c);
  // Of equally near ones the first, whatever order they come in.
  const bool nearer = distance < search.best.distance || (search.found && distance == search.best.distance &&
                                                          arguments->primID < search.best.triangle);
  if (!nearer) return false;
  search.best = {distance, arguments->primID, w};
  search.found = true;
  query.radius = kHair * distance + kRounding * (length(a) + length(b) + length(c));
  return true;
}

/// Collects the nearest point of every triangle within a radius.
struct NearPoints {
  const io::TriangleMesh& mesh;
  float radius;
  std::vector<MeshQuery::Nearest>& found;
};

bool collect(RTCPointQueryFunctionArguments* arguments) {
  auto& near = *static_cast<NearPoints*>(arguments->userPtr);
  const auto& triangle = near.mesh.triangles[arguments->primID];
  const Vec3f p(arguments->query->x, arguments->query->y, arguments->query->z);
  const Vec3f a = near.mesh.vertices[triangle[0]] - p, b = near.mesh.vertices[triangle[1]] - p,
              c = near.mesh.vertices[triangle[2]] - p;
  const std::array<float, 3> w = nearest_weights({}, a, b, c);
  const float distance = length(w[0] * a + w[1] * b + w[2] * c);
  if (distance < near.radius) near.found.push_back({distance, arguments->primID, w});
  return false;
}

/// Collects every crossing, and lets the ray go on.
struct Crossings {
  RTCIntersectContext context;
  std::vector<MeshQuery::Crossing>* found = nullptr;
};

void note_crossing(const RTCFilterFunctionNArguments* arguments) {
  const auto* crossings = reinterpret_cast<const Crossings*>(arguments->context);
  if (arguments->valid[0] == 0) return;
  const unsigned n = arguments->N;
  const float along = RTCRayN_dir_x(arguments->ray, n, 0) * RTCHitN_Ng_x(arguments->hit, n, 0) +
                      RTCRayN_dir_y(arguments->ray, n, 0) * RTCHitN_Ng_y(arguments->hit, n, 0) +
                      RTCRayN_dir_z(arguments->ray, n, 0) * RTCHitN_Ng_z(arguments->hit, n, 0);
  crossings->found->push_back({RTCRayN_tfar(arguments->ray, n, 0), along < 0 ? 1 : -1});
  arguments->valid[0] = 0;
}

}  // namespace

struct MeshQuery::Scene {
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;

  ~Scene() {
    if (scene != nullptr) rtcReleaseScene(scene);
    if (device != nullptr) rtcReleaseDevice(device);
  }

  void cross(Vec3f p, Vec3f direction, std::vector<Crossing>& found) const {
    found.clear();
    Crossings crossings{};
    rtcInitIntersectContext(&crossings.context);
    crossings.context.filter = note_crossing;
    crossings.found = &found;
    RTCRay ray{};
    ray.org_x = p.x, ray.org_y = p.y, ray.org_z = p.z;
    ray.dir_x = direction.x, ray.dir_y = direction.y, ray.dir_z = direction.z;
    ray.tnear = 0;
    ray.tfar = INFINITY;
    ray.mask = UINT32_MAX;
    rtcOccluded1(scene, &crossings.context, &ray);
  }
};

Result<std::unique_ptr<MeshQuery>> MeshQuery::create(io::TriangleMesh mesh, InsideRule rule) {
  std::unique_ptr<MeshQuery> query(new MeshQuery(std::move(mesh), rule));
  Scene& scene = *query->scene_;
  scene.device = rtcNewDevice(nullptr);
  if (scene.device == nullptr) return Error{"a mesh: Embree does not run on this processor"};
  scene.scene = rtcNewScene(scene.device);
  rtcSetSceneFlags(scene.scene, static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_COMPACT |
                                                           RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION));
  const io::TriangleMesh& m = query->mesh_;
  RTCGeometry geometry = rtcNewGeometry(scene.device, RTC_GEOMETRY_TYPE_TRIANGLE);
  // Embree reads four numbers where there are three: the last vertex needs one behind it.
  query->mesh_.vertices.emplace_back();
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, m.vertices.data(), 0,
                             sizeof(Vec3f), m.vertices.size() - 1);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, m.triangles.data(), 0,
                             sizeof(m.triangles[0]), m.triangles.size());
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene.scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene.scene);
  const RTCError error = rtcGetDeviceError(scene.device);
  if (error == RTC_ERROR_OUT_OF_MEMORY) return Error{"a mesh: Embree: out of memory"};
  if (error != RTC_ERROR_NONE) return Error{"a mesh: Embree: error " + std::to_string(error)};
  return query;
}

MeshQuery::MeshQuery(io::TriangleMesh mesh, InsideRule rule)
    : mesh_(std::move(mesh)), rule_(rule), scene_(std::make_unique<Scene>()) {}

std::optional<MeshQuery::Nearest> MeshQuery::nearest(Vec3f p, float radius) const {
  NearestSearch search{mesh_, {radius, 0, {}}};
  RTCPointQuery query{p.x, p.y, p.z, 0, kHair * radius};
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  rtcPointQuery(scene_->scene, &query, &context, consider, &search);
  return search.found ? std::optional(search.best) : std::nullopt;
}

std::optional<MeshQuery::Nearest> MeshQuery::nearest_that(
    Vec3f p, float radius, const std::function<bool(const Nearest&)>& holds) const {
  const std::optional<Nearest> first = nearest(p, radius);
  if (!first || holds(*first)) return first;
  thread_local std::vector<Nearest> found;
  found.clear();
  NearPoints near{mesh_, radius, found};
  RTCPointQuery query{p.x, p.y, p.z, 0, kHair * radius};
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  rtcPointQuery(scene_->scene, &query, &context, collect, &near);
  std::sort(found.begin(), found.end(), [](const Nearest& a, const Nearest& b) {
    return std::tie(a.distance, a.triangle) < std::tie(b.distance, b.triangle);
  });
  // Fine meshes have very many triangles within a radius, and what holds of one holds of its neighbours.
  const float close = radius / 8;
  std::vector<Vec3f> refused = {place(*first)};
  for (const Nearest& one : found) {
    const Vec3f here = place(one);
    const bool near_refused = std::any_of(refused.begin(), refused.end(),
                                          [&](Vec3f other) { return length(here - other) < close; });
    if (near_refused) continue;
    if (holds(one)) return one;
    refused.push_back(here);
  }
  return std::nullopt;
}

void MeshQuery::crossings(Vec3f p, int axis, std::vector<Crossing>& crossings) const {
  Vec3f direction;
  direction[axis] = 1;
  scene_->cross(p, direction, crossings);
  std::sort(crossings.begin(), crossings.end());
}

std::optional<std::pair<float, float>> MeshQuery::first_and_last(Vec3f p, Vec3f direction) const {
  thread_local std::vector<Crossing> found;
  scene_->cross(p, direction, found);
  if (found.empty()) return std::nullopt;
  const auto [first, last] = std::minmax_element(found.begin(), found.end());
  return std::pair(first->distance, last->distance);
}

bool MeshQuery::inside(Vec3f p) const {
  // Oblique, so that they seldom meet an edge of what people model along the axes.
  constexpr Vec3f kWays[] = {
      {0.8623f, 0.4127f, 0.2931f}, {-0.3217f, 0.9013f, 0.2891f}, {0.1931f, -0.3571f, 0.9139f}};
  thread_local std::vector<Crossing> found;
  int votes = 0;
  for (const Vec3f& way : kWays) {
    scene_->cross(p, way, found);
    votes += tells_inside(found) ? 1 : 0;
  }
  return votes >= 2;
}

#else

struct MeshQuery::Scene {};

Result<std::unique_ptr<MeshQuery>> MeshQuery::create(io::TriangleMesh, InsideRule) {
  return Error{"what is made of meshes is not in this build: it was made without Embree 3"};
}
MeshQuery::MeshQuery(io::TriangleMesh, InsideRule rule) : rule_(rule) {}
std::optional<MeshQuery::Nearest> MeshQuery::nearest(Vec3f, float) const {
  return {};
}
std::optional<MeshQuery::Nearest> MeshQuery::nearest_that(Vec3f, float,
                                                          const std::function<bool(const Nearest&)>&) const {
  return {};
}
void MeshQuery::crossings(Vec3f, int, std::vector<Crossing>& crossings) const {
  crossings.clear();
}
std::optional<std::pair<float, float>> MeshQuery::first_and_last(Vec3f, Vec3f) const {
  return {};
}
bool MeshQuery::inside(Vec3f) const {
  return false;
}

#endif

MeshQuery::~MeshQuery() = default;

Vec3f MeshQuery::place(const Nearest& found) const {
  const io::Triangle& t = mesh_.triangles[found.triangle];
  Vec3f sum;
  for (std::size_t k = 0; k < 3; ++k) sum = sum + found.weights[k] * mesh_.vertices[t[k]];
  return sum;
}

bool MeshQuery::tells_inside(std::span<const Crossing> crossings) const {
  if (rule_ != InsideRule::winding) return crossings.size() % 2 != 0;
  int turns = 0;
  for (const Crossing& crossing : crossings) turns += crossing.turn;
  return turns != 0;
}

bool MeshQuery::ends_outside(const std::vector<Crossing>& crossings) const {
  return !tells_inside(crossings);
}

void MeshQuery::changes(const std::vector<Crossing>& crossings, std::vector<float>& distances) const {
  distances.clear();
  int turns = 0;
  bool inside = false;
  for (const Crossing& crossing : crossings) {
    turns += crossing.turn;
    const bool now = rule_ == InsideRule::winding ? turns != 0 : !inside;
    if (now != inside) distances.push_back(crossing.distance);
    inside = now;
  }
}

}  // namespace gvx::mesh
