// gvx build, info, verify and render of surfaces, as a user runs them.

#include "gvx/io/image.h"
#include "program_support.h"

namespace gvx {
namespace {

namespace fs = std::filesystem;

class SurfaceProgram : public ProgramTest {
 protected:
  SurfaceProgram() : ProgramTest("gvx_surface_program") {}

  void SetUp() override {
    ProgramTest::SetUp();
    put_waves("waves.ply", 90, {0, 0, 0});
  }

  /// A sheet with waves, of 2 * size^2 triangles, red to the left and green to the right.
  void put_waves(const std::string& name, int size, std::array<double, 3> corner) const {
    std::ofstream file(path(name));
    file.precision(17);
    file << "ply\nformat ascii 1.0\nelement vertex " << (size + 1) * (size + 1)
         << "\nproperty double x\nproperty double y\nproperty double z\n"
            "property uchar red\nproperty uchar green\nproperty uchar blue\nelement face "
         << size * size << "\nproperty list uchar int vertex_indices\nend_header\n";
    for (int j = 0; j <= size; ++j) {
      for (int i = 0; i <= size; ++i) {
        const double x = 4.0 * i / size, y = 4.0 * j / size;
        file << corner[0] + x << ' ' << corner[1] + y << ' '
             << corner[2] + 0.3 * std::sin(3 * x) * std::cos(2 * y)
             << (2 * i < size ? " 220 40 40\n" : " 40 200 40\n");
      }
    }
    for (int j = 0; j < size; ++j) {
      for (int i = 0; i < size; ++i) {
        const int v = j * (size + 1) + i;
        file << "4 " << v << ' ' << v + 1 << ' ' << v + size + 2 << ' ' << v + size + 1 << '\n';
      }
    }
  }
};

TEST_F(SurfaceProgram, builds_describes_verifies_and_renders) {
  const Outcome built = gvx("build waves.ply -o waves.gvx --up z");
  ASSERT_EQ(built.status, 0) << built.output;
  EXPECT_NE(built.output.find("a surface of 16200 triangles"), std::string::npos) << built.output;
  const auto info = nlohmann::json::parse(gvx("info waves.gvx --json").output);
  EXPECT_EQ(info["triangles"], 16200);
  EXPECT_EQ(info["up"], "z");
  EXPECT_EQ(info["source"], "waves.ply");
  EXPECT_NEAR(info["maximum"][0].get<double>(), 4, 1e-6);
  const Outcome verified = gvx("verify waves.gvx");
  EXPECT_EQ(verified.status, 0);
  EXPECT_NE(verified.output.find("sound: a surface"), std::string::npos) << verified.output;
  for (const char* flags : {"", " --threads 1 --memory 64K", " --memory 20K --threads 3"}) {
    const Outcome rendered = gvx("render waves.gvx -o a.png --size 200x150" + std::string(flags));
    ASSERT_EQ(rendered.status, 0) << rendered.output;
    if (!fs::exists(path("first.png"))) fs::copy_file(path("a.png"), path("first.png"));
    EXPECT_EQ(shell("cmp '" + path("a.png") + "' '" + path("first.png") + "'").status, 0) << flags;
  }
  ASSERT_EQ(gvx("render waves.gvx -o a.png --size 200x150 --save-scene saved.json --quiet").status, 0);
  ASSERT_EQ(gvx("render saved.json -o a.png --quiet").status, 0);
  EXPECT_EQ(shell("cmp '" + path("a.png") + "' '" + path("first.png") + "'").status, 0);
  // The mesh itself looks the same.
  EXPECT_EQ(gvx("render waves.ply -o b.png --size 200x150 --up z --quiet").status, 0);
  const auto store = io::read_png(path("first.png")).value(), mesh = io::read_png(path("b.png")).value();
  EXPECT_EQ(store.rgba, mesh.rgba);
  // Red to the left, green to the right.
  int red[2] = {}, green[2] = {};
  for (std::size_t i = 0; i < store.rgba.size(); i += 4) {
    const int more_red = int(store.rgba[i]) - int(store.rgba[i + 1]);
    const std::size_t right = i / 4 % 200 / 100;
    red[right] += more_red > 40 ? 1 : 0;
    green[right] += more_red < -40 ? 1 : 0;
  }
  EXPECT_GT(red[0], 3 * green[0] + 1000);
  EXPECT_GT(green[1], 3 * red[1]);
}

TEST_F(SurfaceProgram, keeps_its_size_at_a_place_on_a_map) {
  put_waves("map.ply", 60, {500000, 5400000, 300});
  ASSERT_EQ(gvx("build map.ply -o map.gvx").status, 0);
  const auto info = nlohmann::json::parse(gvx("info map.gvx --json").output);
  for (int axis = 0; axis < 2; ++axis) {
    const double low = info["minimum"][axis], high = info["maximum"][axis];
    EXPECT_NEAR(high - low, 4, 1e-6);
  }
  put_waves("here.ply", 60, {0, 0, 0});
  for (const char* name : {"map.ply", "here.ply"}) {
    const std::string picture = std::string(name) + ".png";
    ASSERT_EQ(gvx(std::string("render ") + name + " -o " + picture + " --size 120x90 --up z --quiet").status,
              0);
  }
  const auto map = io::read_png(path("map.ply.png")).value(),
             here = io::read_png(path("here.ply.png")).value();
  int differ = 0;
  for (std::size_t i = 0; i < map.rgba.size(); ++i)
    differ += std::abs(map.rgba[i] - here.rgba[i]) > 24 ? 1 : 0;
  EXPECT_LT(differ, 120) << "single precision would tear it apart";
}

TEST_F(SurfaceProgram, says_what_does_not_go_together) {
  ASSERT_EQ(gvx("build waves.ply -o waves.gvx").status, 0);
  expect_error("build waves.ply -o waves.gvx", "already exists");
  expect_error("build waves.ply -o a.gvx --as surface --resolution 64", "--as surface");
  expect_error("build waves.ply -o a.gvx --brick 8", "--brick");
  expect_error("render waves.gvx -o a.png --mode maximum", "waves.gvx: mode");
  expect_error("render waves.gvx -o a.png --clip 0,0,0,0.5,1,1", "waves.gvx: clip");
  expect_error("render repeat:waves.gvx -o a.png", "surface");
  expect_error("render waves.gvx -o a.png --proxy nodes", "no voxels");
  expect_error("render waves.gvx -o a.png --memory 500", "memory");
  expect_error("build waves.ply -o a.gvx --memory 1K", "--memory");
  expect_error("render waves.gvx -o a.png --camera 'eye=1e7,1e7,1e7;target=2,2,0;height=4'", "camera");
  EXPECT_FALSE(fs::exists(path("a.png")));
  EXPECT_FALSE(fs::exists(path("a.gvx")));
  const Outcome voxels = gvx("build waves.ply -o voxels.gvx --as voxels --resolution 40");
  EXPECT_EQ(voxels.status, 0) << voxels.output;
  EXPECT_NE(voxels.output.find("voxels"), std::string::npos);
}

TEST_F(SurfaceProgram, a_damaged_store_is_an_error_that_names_it) {
  ASSERT_EQ(gvx("build waves.ply -o waves.gvx").status, 0);
  const auto size = fs::file_size(path("waves.gvx"));
  for (const std::uintmax_t left : {size / 2, std::uintmax_t{300}, std::uintmax_t{10}}) {
    fs::copy_file(path("waves.gvx"), path("cut.gvx"), fs::copy_options::overwrite_existing);
    fs::resize_file(path("cut.gvx"), left);
    for (const char* command : {"verify cut.gvx", "info cut.gvx", "render cut.gvx -o a.png"}) {
      expect_error(command, "cut.gvx");
    }
  }
  {
    std::fstream file(path("waves.gvx"), std::ios::binary | std::ios::in | std::ios::out);
    file.seekp(2000);
    file.write("damaged damaged", 15);
  }
  expect_error("verify waves.gvx", "waves.gvx: corrupt: ");
}

TEST_F(SurfaceProgram, a_build_that_is_killed_leaves_no_store) {
  put_waves("large.ply", 500, {0, 0, 0});
  for (const char* seconds : {"0.1", "0.3", "0.6"}) {
    shell("cd '" + folder() + "' && timeout -s KILL " + seconds +
          " " GVX_PROGRAM " build large.ply -o large.gvx");
    EXPECT_FALSE(fs::exists(path("large.gvx"))) << seconds;
  }
  const Outcome built = gvx("build large.ply -o large.gvx --memory 16M");
  EXPECT_EQ(built.status, 0) << built.output;
  EXPECT_EQ(gvx("verify large.gvx").status, 0);
  EXPECT_FALSE(fs::exists(path("large.gvx.partial")));
}

TEST_F(SurfaceProgram, stands_among_volumes_in_a_scene) {
  ASSERT_EQ(gvx("build waves.ply -o waves.gvx").status, 0);
  std::ofstream(path("scene.json")) << R"({"size": [160, 120], "objects": [
      {"volume": "sponge", "transform": {"scale": 2, "translate": [1, 1, -1]}}, {"volume": "waves.gvx"}],
      "camera": {"eye": [2, -7, 3], "target": [2, 2, 0], "fov": 40}})";
  const Outcome rendered = gvx("render scene.json -o a.png --stats stats.json --save-scene saved.json");
  ASSERT_EQ(rendered.status, 0) << rendered.output;
  EXPECT_EQ(read_json("stats.json")["converged"], true);
  ASSERT_EQ(gvx("render saved.json -o b.png").status, 0);
  EXPECT_EQ(shell("cmp '" + path("a.png") + "' '" + path("b.png") + "'").status, 0);
  ASSERT_EQ(gvx("render scene.json -o c.png --budget 5ms --budget-frames 100000").status, 0);
  EXPECT_EQ(shell("cmp '" + path("a.png") + "' '" + path("c.png") + "'").status, 0);
}

}  // namespace
}  // namespace gvx
