// Scenes of several objects: what overlaps is seen together, in order along each ray.

#include <cmath>
#include <cstdio>
#include <string>

#include <gtest/gtest.h>

#include "gvx/render/tile/object_tiles.h"
#include "object_scenes.h"

namespace gvx::tests {
namespace {

/// Tiles of rays and rays one by one show the same, and both what the fields say.
void expect_right(const ObjectScene& scene, const std::string& what, double least_decibels) {
  HowRendered one_by_one;
  one_by_one.one_ray_at_a_time = true;
  const render::Picture picture = ResidentScene(scene, {}).render_exact();
  const render::Picture plain = ResidentScene(scene, one_by_one).render_exact();
  const render::Picture reference = render_reference(scene, 0.002);
  const double alike = psnr(picture, plain), right = psnr(picture, reference);
  std::printf("%-40s %6.1f dB to one ray at a time, %5.1f dB to the fields\n", what.c_str(), alike, right);
  EXPECT_GE(alike, 60) << what;
  EXPECT_GE(right, least_decibels) << what;
}

TEST(Objects, that_are_composited_show_what_their_fields_say) {
  for (const std::uint32_t seed : {1u, 2u, 3u}) {
    for (const int objects : {2, 5, 30}) {
      const std::string what = std::to_string(objects) + " objects, seed " + std::to_string(seed);
      expect_right(random_scene(seed, objects, objects > 5 ? 2.0 : 0.5), what, 40);
    }
  }
}

}  // namespace
}  // namespace gvx::tests
