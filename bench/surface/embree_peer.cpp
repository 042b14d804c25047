#include "embree_peer.h"

#if defined(GVX_WITH_EMBREE)
#include <algorithm>
#include <atomic>
#include <chrono>
#include <string>

#include <embree3/rtcore.h>

#include "gvx/core/result.h"
#include "gvx/exec/parallel.h"
#include "gvx/exec/tile_grid.h"
#include "gvx/surface/draw/surface_shading.h"
#endif

namespace gvx::bench {

EmbreePeer::EmbreePeer() = default;
EmbreePeer::~EmbreePeer() = default;

#if defined(GVX_WITH_EMBREE)

struct EmbreePeer::Scene {
  Scene(const exec::Device& cpu_, const Model& model_)
      : cpu(cpu_), model(model_), device(rtcNewDevice(("threads=" + std::to_string(cpu.threads())).c_str())) {
    GVX_CHECK(device != nullptr);
    rtcSetDeviceMemoryMonitorFunction(
        device,
        [](void* held, ssize_t more, bool) {
          static_cast<std::atomic<std::int64_t>*>(held)->fetch_add(more);
          return true;
        },
        &bytes);
    const auto start = std::chrono::steady_clock::now();
    scene = rtcNewScene(device);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, model.places.data(), 0,
                               sizeof(Vec3f), model.places.size());
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, model.triangles.data(),
                               0, sizeof(io::Triangle), model.triangles.size());
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene);
    seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    GVX_CHECK(rtcGetDeviceError(device) == RTC_ERROR_NONE);
  }
  ~Scene() {
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
  }
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;

  /// 4 x 4 pixels.
  void draw_packet(const surface::SurfaceView& view, const surface::SurfaceLight& light, std::uint32_t x0,
                   std::uint32_t y0, std::vector<PeerPixel>& pixels) const {
    constexpr std::uint32_t kEdge = 4;
    const scene::CameraView& camera = view.camera;
    alignas(64) RTCRayHit16 rays;
    alignas(64) int valid[16];
    for (std::uint32_t i = 0; i < 16; ++i) {
      const std::uint32_t x = x0 + i % kEdge, y = y0 + i / kEdge;
      valid[i] = x < view.width && y < view.height ? -1 : 0;
      // The way is 1 along the view, so that Embree's distance is depth.
      const Vec3f origin(camera.eye),
          way(camera.forward + (x + 0.5 - camera.half_width) * camera.pixel * camera.right +
              (camera.half_height - y - 0.5) * camera.pixel * camera.up);
      rays.ray.org_x[i] = origin.x, rays.ray.org_y[i] = origin.y, rays.ray.org_z[i] = origin.z;
      rays.ray.dir_x[i] = way.x, rays.ray.dir_y[i] = way.y, rays.ray.dir_z[i] = way.z;
      rays.ray.tnear[i] = 0, rays.ray.tfar[i] = INFINITY, rays.ray.time[i] = 0;
      rays.ray.mask[i] = ~0u, rays.ray.flags[i] = 0;
      rays.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID, rays.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
    }
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    rtcIntersect16(valid, scene, &context, &rays);
    for (std::uint32_t i = 0; i < 16; ++i) {
      if (valid[i] == 0 || rays.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) continue;
      const std::uint32_t x = x0 + i % kEdge, y = y0 + i / kEdge;
      const io::Triangle& triangle = model.triangles[rays.hit.primID[i]];
      const float u = rays.hit.u[i], v = rays.hit.v[i], w = 1 - u - v;
      const auto between = [&](const std::vector<Vec3f>& of) {
        return w * of[triangle[0]] + u * of[triangle[1]] + v * of[triangle[2]];
      };
      PeerPixel& pixel = pixels[std::size_t{y} * view.width + x];
      pixel.depth = rays.ray.tfar[i];
      pixel.color = light.shade(between(model.normals), between(model.colors), x, y, double(pixel.depth));
    }
  }

  exec::Device cpu;
  const Model& model;
  std::atomic<std::int64_t> bytes{0};
  RTCDevice device;
  RTCScene scene = nullptr;
  double seconds = 0;
};

std::unique_ptr<EmbreePeer> EmbreePeer::create(const exec::Device& cpu, const Model& model) {
  std::unique_ptr<EmbreePeer> peer(new EmbreePeer);
  peer->scene_ = std::make_unique<Scene>(cpu, model);
  return peer;
}

double EmbreePeer::build_seconds() const {
  return scene_->seconds;
}

std::uint64_t EmbreePeer::bytes() const {
  return static_cast<std::uint64_t>(scene_->bytes.load());
}

void EmbreePeer::draw(const surface::SurfaceView& view, std::vector<PeerPixel>& pixels) const {
  pixels.assign(std::size_t{view.width} * view.height, {});
  const surface::SurfaceLight light(view.lighting, view.camera, {});
  constexpr std::uint32_t kTile = 32;
  const exec::TileGrid grid{view.width, view.height, kTile};
  exec::parallel_for(scene_->cpu, grid.tiles(), [&](std::size_t tile) {
    const auto x0 = static_cast<std::uint32_t>(tile % grid.tiles_x()) * kTile,
               y0 = static_cast<std::uint32_t>(tile / grid.tiles_x()) * kTile;
    for (std::uint32_t y = y0; y < std::min(y0 + kTile, view.height); y += 4) {
      for (std::uint32_t x = x0; x < std::min(x0 + kTile, view.width); x += 4) {
        scene_->draw_packet(view, light, x, y, pixels);
      }
    }
  });
}

#else

struct EmbreePeer::Scene {};

std::unique_ptr<EmbreePeer> EmbreePeer::create(const exec::Device&, const Model&) {
  return nullptr;
}
double EmbreePeer::build_seconds() const {
  return 0;
}
std::uint64_t EmbreePeer::bytes() const {
  return 0;
}
void EmbreePeer::draw(const surface::SurfaceView&, std::vector<PeerPixel>&) const {}

#endif

}  // namespace gvx::bench
