// What docs/library.md shows does what it says.

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "gvx/core/result.h"

gvx::Status render(const std::string& path, std::span<std::uint8_t> pixels);
gvx::Status render_scene(const std::string& json, std::span<std::uint8_t> pixels);

namespace gvx {
namespace {

TEST(LibraryPage, renders_a_scene_from_a_text) {
  std::vector<std::uint8_t> pixels(4 * 48 * 32);
  const Status rendered =
      render_scene(R"({"volume": "sponge", "size": [48, 32], "transparent": true})", pixels);
  ASSERT_TRUE(rendered.ok()) << rendered.error().message;
  EXPECT_EQ(pixels[3], 0);                         // a corner
  EXPECT_GT(pixels[4 * (48 * 16 + 24) + 3], 200);  // the middle
  const Status refused = render_scene(R"({"volume": "sponge", "mode": "xray"})", pixels);
  EXPECT_EQ(refused.error().message.rfind("request: mode: ", 0), 0u) << refused.error().message;
}

TEST(LibraryPage, an_error_of_a_store_names_it) {
  std::vector<std::uint8_t> pixels(std::size_t{4} * 512 * 512);
  EXPECT_NE(render("none.gvx", pixels).error().message.find("none.gvx"), std::string::npos);
}

}  // namespace
}  // namespace gvx
