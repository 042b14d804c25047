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

void expect_color(const scene::TransferFunction& f, double value, Vec3d color,
                  double tolerance = 0.51 / 255) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(f.color(value)[c], color[c], tolerance) << value << ' ' << c;
}

TEST(TransferFunctionFile, interpolates_diverging_maps_through_white) {
  // ParaView's Cool to Warm, and the table that Moreland gives for it.
  const auto f = read(R"({"ColorSpace": "Diverging", "NanColor": [1, 1, 0], "Name": "Cool to Warm",
    "RGBPoints": [0, 0.23137254902, 0.298039215686, 0.752941176471, 32, 0.705882352941, 0.0156862745098,
                  0.149019607843]})")
                     .value();
  const int table[][4] = {{0, 59, 76, 192},    {4, 98, 130, 234},   {8, 141, 176, 254},
                          {12, 184, 208, 249}, {16, 221, 221, 221}, {20, 245, 196, 173},
                          {24, 244, 154, 123}, {28, 222, 96, 77},   {32, 180, 4, 38}};
  for (const auto& [value, r, g, b] : table) expect_color(f, value, Vec3d(r, g, b) / 255.0, 1.1 / 255);
}

TEST(TransferFunctionFile, interpolates_hues) {
  const std::string points = R"("RGBPoints": [0, 1, 0, 0, 4, 0, 0, 1]})";
  const auto straight = read(R"({"ColorSpace": "HSV", )" + points).value();
  expect_color(straight, 1, {1, 1, 0});
  expect_color(straight, 2, {0, 1, 0});
  expect_color(straight, 3, {0, 1, 1});
  const auto wrapped = read(R"({"ColorSpace": "HSV", "HSVWrap": 1, )" + points).value();
  expect_color(wrapped, 2, {1, 0, 1});
  expect_color(wrapped, 1, {1, 0, 0.5});
}

TEST(TransferFunctionFile, steps_have_the_colour_of_their_second_point) {
  const auto f = read(R"({"ColorSpace": "Step", "RGBPoints": [0, 1, 0, 0, 1, 0, 1, 0, 2, 0, 0, 1]})").value();
  EXPECT_EQ(f.color(-1), Vec3d(1, 0, 0));
  EXPECT_EQ(f.color(0.5), Vec3d(0, 1, 0));
  EXPECT_EQ(f.color(0.999), Vec3d(0, 1, 0));
  EXPECT_EQ(f.color(1.5), Vec3d(0, 0, 1));
  EXPECT_EQ(f.color(3), Vec3d(0, 0, 1));
}

TEST(TransferFunctionFile, categories_are_those_of_the_annotations) {
  const std::string colors = R"("IndexedColors": [1, 0, 0, 0, 1, 0, 0, 0, 1])";
  const auto plain = read("{" + colors + "}").value();
  for (int label = 0; label < 3; ++label) EXPECT_EQ(plain.color(label)[label], 1) << label;
  EXPECT_EQ(plain.opacity(0), 0);
  EXPECT_EQ(plain.opacity(1), plain.opacity(2));
  const std::string annotations = R"(, "Annotations": ["7", "bone", "2", "air", "3", "fat", "9", "gold"])";
  const auto named = read("{" + colors + annotations + "}").value();
  EXPECT_EQ(named.color(7), Vec3d(1, 0, 0));
  EXPECT_EQ(named.color(2), Vec3d(0, 1, 0));
  EXPECT_EQ(named.color(3), Vec3d(0, 0, 1));
  EXPECT_EQ(named.color(9), Vec3d(1, 0, 0));
  EXPECT_EQ(named.color(2.9), Vec3d(0, 0, 1));
  const std::string points = R"(, "RGBPoints": [0, 0, 0, 0, 1, 1, 1, 1])";
  EXPECT_EQ(read("{" + colors + points + "}").value().color(0.5), Vec3d(0.5));
  EXPECT_EQ(read("{" + colors + points + R"(, "IndexedLookup": true})").value().color(2), Vec3d(0, 0, 1));
}

TEST(TransferFunctionFile, refuses_what_is_none_in_one_line) {
  for (const char* text :
       {"", "{", "[]", "3", "{\"RGBPoints\": 3}", "{\"RGBPoints\": []}", "{\"RGBPoints\": [1, 2, 3]}",
        "{\"RGBPoints\": [0, 0, 0, \"x\"]}", "{\"RGBPoints\": [1, 0, 0, 0, 0, 0, 0, 0]}",
        "{\"RGBPoints\": [0, 0, 0, 7]}", "{\"RGBPoints\": [0, 0, 0, 0], \"ColorSpace\": \"Munsell\"}",
        "{\"RGBPoints\": [0, 0, 0, 0], \"ColorSpace\": 3}", "{\"IndexedColors\": [0, 0]}",
        "{\"IndexedColors\": [0, 0, 0], \"Annotations\": [\"1\"]}",
        "{\"IndexedColors\": [0, 0, 0], \"Annotations\": [\"air\", \"0\"]}",
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
