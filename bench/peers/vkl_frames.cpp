// Open VKL's frames for bench/peers: a ray caster over its CPU device, version 2. Packets of 4 x 4 rays by
// its vectors of 16, which it has with AVX-512 only: interval iterators leap over what the function does not
// show, then steps of one voxel are sampled, and the gradients of what is seen; oneTBB over tiles of pixels.
//
//     gvx_peers_vkl FILE.raw SIZE THREADS          SIZE^3 u8 voxels

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <vector>

// The order matters.
// clang-format off
#include <openvkl/openvkl.h>
#include <openvkl/device/openvkl.h>
// clang-format on

#include "ray_caster.h"

namespace {

using namespace gvx;
using bench::Voxels;

constexpr int kAcross = 4, kLanes = kAcross * kAcross;

/// The values that a function shows.
std::vector<vkl_range1f> visible_ranges(const scene::TransferFunction& function) {
  constexpr float kFar = 1e9f;
  std::vector<vkl_range1f> ranges;
  const auto add = [&](float lower, float upper) {
    if (!ranges.empty() && ranges.back().upper == lower) {
      ranges.back().upper = upper;
    } else {
      ranges.push_back({lower, upper});
    }
  };
  const auto& points = function.opacities;
  if (points.front().opacity > 0) add(-kFar, static_cast<float>(points.front().value));
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    if (points[i].opacity > 0 || points[i + 1].opacity > 0) {
      add(static_cast<float>(points[i].value), static_cast<float>(points[i + 1].value));
    }
  }
  if (points.back().opacity > 0) add(static_cast<float>(points.back().value), kFar);
  return ranges;
}

/// Ends the program where there is none, or none that has vectors of 16.
VKLDevice open_device(int threads) {
  vklInit();
  const VKLDevice device = vklNewDevice("cpu_16");
  if (device) {
    vklDeviceSetInt(device, "numThreads", threads);
    vklDeviceSetString(device, "logOutput", "cerr");  // answers go to standard output
    vklCommitDevice(device);
    if (vklDeviceGetLastErrorCode(device) == VKL_NO_ERROR) return device;
  }
  std::fprintf(stderr, "Open VKL: no device cpu_16: a processor with AVX-512 is needed\n");
  std::exit(1);
}

class VklCaster : public bench::RayCaster {
 public:
  VklCaster(const Voxels& voxels, int threads)
      : RayCaster(voxels.size, threads),
        device_(open_device(threads)),
        volume_(vklNewVolume(device_, "structuredRegular")) {
    const VKLData data =
        vklNewData(device_, voxels.value.size(), VKL_UCHAR, voxels.value.data(), VKL_DATA_DEFAULT, 0);
    vklSetVec3i(volume_, "dimensions", voxels.size, voxels.size, voxels.size);
    vklSetVec3f(volume_, "gridOrigin", 0, 0, 0);
    vklSetVec3f(volume_, "gridSpacing", 1, 1, 1);
    vklSetData(volume_, "data", data);
    vklRelease(data);
    vklCommit(volume_);
    sampler_ = vklNewSampler(volume_);
    vklCommit(sampler_);
  }
  ~VklCaster() override {
    if (context_) vklRelease(context_);
    vklRelease(sampler_);
    vklRelease(volume_);
    vklReleaseDevice(device_);
  }

 private:
  /// 4 x 4 rays. What goes on is -1, as the library has it, else 0.
  struct Packet {
    Way way[kLanes];
    alignas(64) int goes_on[kLanes];
    alignas(64) float place[kLanes];  // of the next sample
    Pixel pixel[kLanes];
  };

  void prepare() override {
    if (context_) vklRelease(context_);
    const std::vector<vkl_range1f> ranges = visible_ranges(view().function);
    const VKLData data = vklNewData(device_, ranges.size(), VKL_BOX1F, ranges.data(), VKL_DATA_DEFAULT, 0);
    context_ = vklNewIntervalIteratorContext(sampler_);
    vklSetData(context_, "valueRanges", data);
    vklRelease(data);
    vklCommit(context_);
    iterator_bytes_ = vklGetIntervalIteratorSize16(&context_);
  }

  void draw(const scene::CameraView& rays, const Tile& tile) override {
    const Vec3f to_light(-rays.forward);
    std::vector<char> iterator(iterator_bytes_);
    for (int y = tile.rows().begin(); y < tile.rows().end(); y += kAcross) {
      for (int x = tile.cols().begin(); x < tile.cols().end(); x += kAcross) {
        Packet packet;
        for (int lane = 0; lane < kLanes; ++lane) {
          const int column = x + lane % kAcross, row = y + lane / kAcross;
          const bool inside = column < tile.cols().end() && row < tile.rows().end();
          packet.way[lane] = inside ? way(rays, column, row) : Way();
          packet.goes_on[lane] = packet.way[lane].length > 0 ? -1 : 0;
          packet.place[lane] = 0.5f;
        }
        view().lighting.enabled ? cast<true>(packet, to_light, iterator)
                                : cast<false>(packet, to_light, iterator);
        for (int lane = 0; lane < kLanes; ++lane) {
          const int column = x + lane % kAcross, row = y + lane / kAcross;
          if (column < tile.cols().end() && row < tile.rows().end()) pixel(column, row) = packet.pixel[lane];
        }
      }
    }
  }

  template <bool kLit>
  void cast(Packet& packet, const Vec3f& to_light, std::vector<char>& buffer) {
    vkl_vvec3f16 from, along;
    vkl_vrange1f16 inside;
    for (int lane = 0; lane < kLanes; ++lane) {
      const Way& way = packet.way[lane];
      from.x[lane] = way.from.x;
      from.y[lane] = way.from.y;
      from.z[lane] = way.from.z;
      along.x[lane] = way.along.x;
      along.y[lane] = way.along.y;
      along.z[lane] = way.along.z;
      inside.lower[lane] = 0;
      inside.upper[lane] = way.length;
    }
    const VKLIntervalIterator16 iterator =
        vklInitIntervalIterator16(packet.goes_on, &context_, &from, &along, &inside, nullptr, buffer.data());
    while (true) {
      alignas(64) int found[kLanes] = {};
      VKLInterval16 interval;
      vklIterateInterval16(packet.goes_on, iterator, &interval, found);
      bool some = false;
      for (int lane = 0; lane < kLanes; ++lane) {
        if (found[lane] == 0) packet.goes_on[lane] = 0;
        if (packet.goes_on[lane] == 0) continue;
        some = true;
        const float skipped = interval.tRange.lower[lane] - packet.place[lane];
        packet.place[lane] += std::max(0.0f, std::ceil(skipped));
      }
      if (!some) return;
      while (step<kLit>(packet, interval.tRange.upper, from, along, to_light)) {
      }
    }
  }

  /// Takes a sample of each ray whose next is before these ends. False where there is none.
  template <bool kLit>
  bool step(Packet& packet, const float (&end)[kLanes], const vkl_vvec3f16& from, const vkl_vvec3f16& along,
            const Vec3f& to_light) {
    alignas(64) int steps[kLanes];
    vkl_vvec3f16 place;
    int some = 0;
    for (int lane = 0; lane < kLanes; ++lane) {
      steps[lane] = packet.goes_on[lane] != 0 && packet.place[lane] < end[lane] ? -1 : 0;
      some |= steps[lane];
      place.x[lane] = held(from.x[lane] + packet.place[lane] * along.x[lane]);
      place.y[lane] = held(from.y[lane] + packet.place[lane] * along.y[lane]);
      place.z[lane] = held(from.z[lane] + packet.place[lane] * along.z[lane]);
    }
    if (some == 0) return false;
    alignas(64) float values[kLanes] = {};
    vklComputeSample16(steps, &sampler_, &place, values);
    const Matter* matter[kLanes];
    alignas(64) int seen[kLanes];
    some = 0;
    for (int lane = 0; lane < kLanes; ++lane) {
      matter[lane] = &matter_of(steps[lane] != 0 ? values[lane] : 0.0f);
      seen[lane] = matter[lane]->opacity > 0 ? steps[lane] : 0;
      some |= seen[lane];
      packet.place[lane] += steps[lane] != 0 ? 1.0f : 0.0f;
    }
    if (some == 0) return true;
    vkl_vvec3f16 gradient;
    if constexpr (kLit) vklComputeGradient16(seen, &sampler_, &place, &gradient);
    for (int lane = 0; lane < kLanes; ++lane) {
      if (seen[lane] == 0) continue;
      Vec3f color = matter[lane]->color;
      if constexpr (kLit) {
        color = lit(color, {gradient.x[lane], gradient.y[lane], gradient.z[lane]}, packet.way[lane].along,
                    to_light);
      }
      add(color, matter[lane]->opacity, packet.pixel[lane]);
      if (packet.pixel[lane].opacity >= kOpaque) packet.goes_on[lane] = 0;
    }
    return true;
  }

  VKLDevice device_;
  VKLVolume volume_;
  VKLSampler sampler_;
  VKLIntervalIteratorContext context_;  // of a view; none before the first
  std::size_t iterator_bytes_ = 0;
};

}  // namespace

int main(int argc, char** argv) {
  return bench::serve_caster<VklCaster>(argc, argv);
}
