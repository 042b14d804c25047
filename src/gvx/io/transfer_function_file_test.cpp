#include "gvx/io/transfer_function_file.h"

#include <fstream>

#include <gtest/gtest.h>

namespace gvx::io {
namespace {

Result<scene::TransferFunction> read(const std::string& text) {
  const std::string path = testing::TempDir() + "gvx_tf.json";
  std::ofstream(path, std::ios::binary) << text;
  return read_transfer_function(path);
}

TEST(TransferFunctionFile, reads_paraviews_colour_maps) {
  const auto f = read(R"([{"ColorSpace": "RGB", "Name": "bone", "NanColor": [1, 1, 0],
    "RGBPoints": [-1000, 0, 0, 0, 100, 0.5, 0.25, 0, 3000, 1, 1, 1],
    "Points": [-1000, 0, 0.5, 0, 100, 0, 0.25, 0, 500, 0.8, 0.5, 0]}])")
                     .value();
  ASSERT_EQ(f.colors.size(), 3u);
  EXPECT_EQ(f.color(100), Vec3d(0.5, 0.25, 0));
  EXPECT_DOUBLE_EQ(f.opacity(200), 0.4);  // the midpoint: a quarter of the way to 500
  EXPECT_DOUBLE_EQ(f.opacity(500), 0.8);
}

TEST(TransferFunctionFile, without_opacities_ramps_over_the_colours) {
  const auto f = read(R"({"RGBPoints": [0, 0, 0, 0, 10, 1, 1, 1], "UnitDistance": 2.5})").value();
  EXPECT_DOUBLE_EQ(f.opacity(2.5), 0.25);
  EXPECT_DOUBLE_EQ(f.unit_distance, 2.5);
}

TEST(TransferFunctionFile, interpolates_in_lab_where_asked) {
  const auto f = read(R"({"ColorSpace": "Lab", "RGBPoints": [0, 1, 0, 0, 1, 0, 0, 1]})").value();
  EXPECT_NEAR(f.color(0).x, 1, 1e-3);
  EXPECT_NEAR(f.color(1).z, 1, 1e-3);
  // Halfway between red and blue in L*a*b*: (42.8, 79.7, -20.3), which is this violet.
  EXPECT_NEAR(f.color(0.5).x, 0.79, 0.01);
  EXPECT_NEAR(f.color(0.5).z, 0.53, 0.02);
}

TEST(TransferFunctionFile, refuses_what_is_none_in_one_line) {
  for (const char* text :
       {"", "{", "[]", "3", "{\"RGBPoints\": 3}", "{\"RGBPoints\": []}", "{\"RGBPoints\": [1, 2, 3]}",
        "{\"RGBPoints\": [0, 0, 0, \"x\"]}", "{\"RGBPoints\": [1, 0, 0, 0, 0, 0, 0, 0]}",
        "{\"RGBPoints\": [0, 0, 0, 7]}", "{\"RGBPoints\": [0, 0, 0, 0], \"ColorSpace\": \"Diverging\"}",
        "{\"RGBPoints\": [0, 0, 0, 0], \"Points\": [0, 1, 0.5, 1]}",
        "{\"RGBPoints\": [0, 0, 0, 0], \"Points\": [0, 2, 0.5, 0]}",
        "{\"RGBPoints\": [0, 0, 0, 0], \"UnitDistance\": -1}", "{\"RGBPoints\": [1e999, 0, 0, 0]}"}) {
    const auto f = read(text);
    ASSERT_FALSE(f.ok()) << text;
    EXPECT_NE(f.error().message.find("gvx_tf.json"), std::string::npos);
    EXPECT_EQ(f.error().message.find('\n'), std::string::npos);
  }
  EXPECT_FALSE(read_transfer_function("/no/such/file.json").ok());
}

}  // namespace
}  // namespace gvx::io
