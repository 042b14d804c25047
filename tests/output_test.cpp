// What the program does with its outputs: which it refuses, what it leaves behind, what it says of them.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "gvx/io/image.h"
#include "program_support.h"

namespace gvx {
namespace {

namespace fs = std::filesystem;

class Outputs : public ProgramTest {
 protected:
  Outputs() : ProgramTest("gvx_outputs") {}

  std::string content(const std::string& name) const {
    std::ifstream file(path(name), std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  void put(const std::string& name, const std::string& bytes) const {
    std::ofstream(path(name), std::ios::binary) << bytes;
  }
  /// Runs it, and expects this error and `file` to be as it was.
  void expect_kept(const std::string& file, const std::string& arguments,
                   const std::string& part = "the output is the input") const {
    const std::string before = content(file);
    expect_error(arguments, part);
    EXPECT_EQ(content(file), before) << arguments;
  }
  std::vector<std::string> names(const std::string& folder) const {
    std::vector<std::string> found;
    for (const auto& entry : fs::directory_iterator(path(folder))) found.push_back(entry.path().filename());
    std::sort(found.begin(), found.end());
    return found;
  }
};

const char* const kCube = "v_16x16x16_uint8.raw";

TEST_F(Outputs, an_input_is_never_the_output) {
  put(kCube, std::string(4096, 'x'));
  const std::string cube = kCube;
  expect_kept(cube, "build " + cube + " -o " + cube + " --force");
  expect_kept(cube, "build " + cube + " -o ./" + cube + " --force");
  fs::create_hard_link(path(cube), path("hard.gvx"));
  fs::create_symlink(cube, path("link.gvx"));
  fs::create_symlink("link.gvx", path("again.gvx"));
  for (const char* name : {"hard.gvx", "link.gvx", "again.gvx"}) {
    expect_kept(cube, "build " + cube + " -o " + name + " --force");
    expect_kept(cube, "build - --dims 16,16,16 --dtype u8 -o " + std::string(name) + " --force < " + cube);
  }
  EXPECT_TRUE(fs::is_symlink(path("link.gvx")));
  // What a build writes first counts as well.
  fs::create_hard_link(path(cube), path("other.gvx.partial"));
  expect_kept(cube, "build " + cube + " -o other.gvx");
  // One of several channels.
  put("w_16x16x16_uint8.raw", std::string(4096, 'y'));
  expect_kept(cube, "build w_16x16x16_uint8.raw " + cube + " -o hard.gvx --force");
}

TEST_F(Outputs, the_files_that_a_header_names_are_inputs) {
  const std::string samples(4096, 'x');
  put("data.raw", samples);
  fs::create_hard_link(path("data.raw"), path("data.gvx"));
  put("a.mhd",
      "ObjectType = Image\nNDims = 3\nDimSize = 16 16 16\nElementType = MET_UCHAR\nElementDataFile = "
      "data.raw\n");
  put("a.nhdr",
      "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 16 16 16\nencoding: raw\ndata file: data.raw\n\n");
  for (const std::string header : {"a.mhd", "a.nhdr"}) {
    ASSERT_EQ(gvx("build " + header + " -o sound.gvx --force").status, 0);
    expect_kept("data.raw", "build " + header + " -o data.gvx --force");
    expect_kept("data.raw", "render " + header + " -o a.png --stats data.raw");
    expect_kept("data.raw", "render " + header + " -o a.png --save-scene data.raw");
    expect_kept(header, "render " + header + " -o a.png --stats " + header);
  }
  // Analyze: the header is beside the samples that are named, and the other way round.
  std::string header(348, '\0');
  const auto set = [&](std::size_t at, std::int16_t v) {
    std::copy_n(reinterpret_cast<char*>(&v), 2, header.begin() + static_cast<std::ptrdiff_t>(at));
  };
  set(0, 348), set(40, 3), set(42, 16), set(44, 16), set(46, 16), set(70, 2), set(72, 8);
  put("pair.hdr", header);
  put("pair.img", samples);
  for (const std::string input : {"pair.hdr", "pair.img"}) {
    for (const std::string output : {"pair.hdr", "pair.img"}) {
      expect_kept(output, "render " + input + " -o a.png --stats " + output);
    }
  }
}

TEST_F(Outputs, the_files_beside_a_mesh_are_inputs) {
  put("m.obj", "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  put("m.mtl", "newmtl a\n");
  put("m.gltf", R"({"asset": {"version": "2.0"}, "buffers": [{"uri": "m.bin", "byteLength": 4}]})");
  put("m.bin", "1234");
  expect_kept("m.mtl", "render m.obj -o a.png --stats m.mtl");
  expect_kept("m.obj", "render distance:m.obj -o a.png --stats m.obj");
  expect_kept("m.bin", "render m.gltf -o a.png --stats m.bin");
  expect_kept("m.bin", "render repeat:2:distance:m.gltf -o a.png --save-scene m.bin");
  expect_kept("m.mtl", "render sponge --proxy m.obj -o a.png --stats m.mtl");
  expect_kept("m.obj", "render sponge --proxy m.obj -o a.png --stats m.obj");
}

TEST_F(Outputs, what_a_scene_names_is_an_input) {
  write_ball();
  ASSERT_EQ(gvx("build ball_40x36x30_uint8.raw -o ball.gvx").status, 0);
  put("map.json", R"([{"RGBPoints": [0, 0, 0, 1, 250, 1, 0, 0]}])");
  fs::create_directories(path("scenes"));
  put("scenes/s.json", R"({"volume": "../ball.gvx", "function": "../map.json", "size": [8, 8]})");
  const std::string render = "render scenes/s.json -o a.png ";
  ASSERT_EQ(gvx(render).status, 0);
  for (const std::string file : {"ball.gvx", "map.json", "scenes/s.json"}) {
    expect_kept(file, render + "--stats " + file);
    expect_kept(file, render + "--save-scene " + file);
  }
  fs::create_hard_link(path("ball.gvx"), path("ball.png"));
  expect_kept("ball.gvx", "render scenes/s.json -o ball.png");
  fs::create_hard_link(path("map.json"), path("f.0002.png"));
  expect_kept("map.json", "render ball.gvx --tf map.json --size 8x8 -o f.png --frames 3");
  EXPECT_FALSE(fs::exists(path("f.0001.png")));
}

TEST_F(Outputs, two_outputs_are_two_files) {
  const std::string render = "render sponge --size 8x8 ";
  expect_error(render + "-o a.png --stats a.png", "names the same file");
  expect_error(render + "-o a.png --stats s.json --save-scene ./s.json", "names the same file");
  expect_error(render + "-o a.png --stats a.png.partial", "names the same file");
  expect_error(render + "-o a.png --frames 3 --stats a.0002.png", "names the same file");
  put("one", "");
  fs::create_hard_link(path("one"), path("two"));
  expect_error(render + "-o a.png --stats one --save-scene two", "names the same file");
  EXPECT_EQ(gvx(render + "-o a.png --stats /dev/null --save-scene /dev/null").status, 0);
}

TEST_F(Outputs, a_store_is_a_file_that_ends_in_gvx) {
  put(kCube, std::string(4096, 'x'));
  const std::string build = std::string("build ") + kCube + " --force -o ";
  expect_error(build + "store", "end in .gvx");
  ASSERT_EQ(::mkfifo(path("pipe.gvx").c_str(), 0600), 0);
  expect_error(build + "pipe.gvx", "a device or a pipe");
  EXPECT_TRUE(fs::is_fifo(path("pipe.gvx")));
  fs::create_symlink("/dev/null", path("null.gvx"));
  expect_error(build + "null.gvx", "a device or a pipe");
  fs::create_directories(path("folder.gvx"));
  expect_error(build + "folder.gvx", "a folder has that name");
  // A link to a store stays one.
  fs::create_directories(path("elsewhere"));
  fs::create_symlink("elsewhere/s.gvx", path("link.gvx"));
  ASSERT_EQ(gvx(build + "link.gvx").status, 0);
  ASSERT_EQ(gvx(build + "link.gvx").status, 0);
  EXPECT_TRUE(fs::is_symlink(path("link.gvx")));
  EXPECT_EQ(gvx("verify elsewhere/s.gvx").status, 0);
  EXPECT_EQ(names("elsewhere"), std::vector<std::string>{"s.gvx"});
}

TEST_F(Outputs, devices_and_pipes_are_written_to) {
  const std::string render = "render sponge --size 8x8 --quiet -o a.png ";
  Outcome outcome = gvx(render + "--stats /dev/stdout");
  ASSERT_EQ(outcome.status, 0);
  EXPECT_EQ(nlohmann::json::parse(outcome.output)["converged"], true);
  outcome = gvx(render + "--save-scene /dev/fd/1 > out.json; cat out.json");
  EXPECT_EQ(nlohmann::json::parse(outcome.output)["volume"], "sponge");
  ASSERT_EQ(::mkfifo(path("p.png").c_str(), 0600), 0);
  outcome = shell("cd '" + folder() +
                  "' && { timeout 60 " GVX_PROGRAM
                  " render sponge --size 8x8 -o p.png & timeout 60 cat p.png > copy.png; wait; }");
  EXPECT_EQ(io::read_png(path("copy.png")).value().width, 8u);
  EXPECT_TRUE(fs::is_fifo(path("p.png")));
  ASSERT_EQ(::mkfifo(path("in").c_str(), 0600), 0);
  outcome = shell("cd '" + folder() +
                  "' && { head -c 4096 /dev/zero > in & timeout 60 " GVX_PROGRAM
                  " render in --dims 16,16,16 --dtype u8 -o a.png --size 8x8 --quiet; wait; }");
  EXPECT_EQ(outcome.status, 0);
  EXPECT_NE(outcome.output.find("nothing can be seen"), std::string::npos) << outcome.output;
  // Only root may make one.
  if (shell("mknod '" + path("mynull") + "' c 1 3").status == 0) {
    EXPECT_EQ(gvx(render + "--stats mynull --save-scene mynull").status, 0);
    EXPECT_TRUE(fs::is_character_file(path("mynull")));
    expect_error(std::string("build ") + kCube + " -o mynull --force", "mynull");
    EXPECT_TRUE(fs::is_character_file(path("mynull")));
  }
  if (fs::exists("/dev/full")) expect_error(render + "--stats /dev/full", "/dev/full: cannot write");
  fs::create_symlink("later.json", path("link.json"));
  ASSERT_EQ(gvx(render + "--stats link.json").status, 0);
  EXPECT_TRUE(fs::is_symlink(path("link.json")));
  EXPECT_EQ(read_json("later.json")["converged"], true);
  fs::create_directories(path("folder"));
  expect_error(render + "--stats folder", "a folder has that name");
}

TEST_F(Outputs, signals_leave_nothing_behind) {
  fs::create_directories(path("tmp"));
  fs::create_directories(path("out"));
  std::ofstream(path("z_1000x1000x600_uint8.raw"));
  fs::resize_file(path("z_1000x1000x600_uint8.raw"), 600'000'000);
  // A mesh of which the voxels take long.
  std::ofstream mesh(path("big.obj"));
  for (int y = 0; y <= 300; ++y) {
    for (int x = 0; x <= 300; ++x) mesh << "v " << x << ' ' << y << ' ' << 20 * std::sin(0.1 * x * y) << '\n';
  }
  for (int y = 0; y < 300; ++y) {
    for (int x = 1; x <= 300; ++x) {
      const int v = 301 * y + x;
      mesh << "f " << v << ' ' << v + 1 << ' ' << v + 302 << ' ' << v + 301 << '\n';
    }
  }
  mesh.close();
  shell("cd '" + folder() + "' && head -c 600000000 /dev/zero | gzip -1 > packed_1000x1000x600_uint8.raw.gz");
  const std::string commands[] = {"render z_1000x1000x600_uint8.raw -o out/a.png",
                                  "build z_1000x1000x600_uint8.raw -o out/a.gvx",
                                  "render packed_1000x1000x600_uint8.raw.gz -o out/a.png",
                                  "build packed_1000x1000x600_uint8.raw.gz --type f32 -o out/b.gvx --force",
                                  "render big.obj --resolution 900 -o out/a.png",
                                  "build big.obj --resolution 900 -o out/c.gvx --force",
                                  "build big.obj --memory 8M -o out/d.gvx --force"};
  const std::pair<const char*, int> signals[] = {{"INT", 2}, {"TERM", 15}, {"HUP", 1}};
  int ended = 0, at = 0;
  for (const std::string& command : commands) {
    for (const char* seconds : {"0.02", "0.2", "0.5", "1"}) {
      const auto& [name, number] = signals[++at % 3];
      // Without a shell's job control, which ignores SIGINT of what runs in the background.
      const Outcome outcome = shell("cd '" + folder() + "' && export TMPDIR=\"$PWD/tmp\" && timeout -s " +
                                    name + " " + seconds + " " GVX_PROGRAM " " + command);
      // `timeout` says 124 for a command that it ended.
      EXPECT_TRUE(outcome.status == 124 || outcome.status == 0)
          << command << outcome.status << outcome.output;
      ended += outcome.status == 124 ? 1 : 0;
      EXPECT_EQ(names("tmp"), std::vector<std::string>{}) << command << ' ' << name << ' ' << seconds;
      for (const std::string& left : names("out")) {
        EXPECT_FALSE(left.ends_with(".partial")) << command << ' ' << name << ' ' << seconds;
      }
      if (outcome.status != 0) {
        EXPECT_EQ(names("out"), std::vector<std::string>{}) << command;
      }
      fs::remove_all(path("out"));
      fs::create_directories(path("out"));
    }
  }
  EXPECT_GE(ended, 6);
  // The exit status is that of the signal.
  const Outcome outcome =
      shell("cd '" + folder() +
            "' && " GVX_PROGRAM
            " build - --dims 512,512,100000 --dtype u8 -o out/a.gvx < /dev/zero & sleep 0.3; "
            "kill -TERM $!; wait $!");
  EXPECT_TRUE(outcome.status == 128 + 15) << outcome.status << outcome.output;
  EXPECT_EQ(names("out"), std::vector<std::string>{});
}

TEST_F(Outputs, errors_come_before_a_volume_is_read) {
  // More than can be read in any time.
  const std::string volume = "render - --dims 1000,1000,1000000 --dtype u8 ";
  const auto expect_early = [&](const std::string& arguments, const std::string& part) {
    expect_error(volume + arguments + " < /dev/zero", part);
  };
  put("bad.json", "{}");
  put("bad.ply", "ply\n");
  expect_early("-o no/such/a.png", "-o no/such/a.png: cannot create");
  expect_early("-o a.jpg", "-o a.jpg: the picture's name must end in .png or .exr");
  expect_early("-o a.png --stats no/such/s", "--stats no/such/s: cannot create");
  expect_early("-o a.png --save-scene no/such/s", "--save-scene no/such/s: cannot create");
  expect_early("-o a.png --tf foo", "--tf foo: neither a file nor a preset (presets: ct-bone, ");
  expect_early("-o a.png --tf bad.json", "--tf bad.json: ");
  expect_early("-o a.png --tf gray --tf gray", "--tf: 2 transfer functions for a volume that takes 1");
  expect_early("-o a.png --camera eye=1,2", "--camera: '2' has too few numbers");
  expect_early("-o a.png --camera 'eye=1,2,3;target=1,2,3'", "same point");
  expect_early("-o a.png --camera fov=190", "fov");
  expect_early("-o a.png --key-frame 1:eye=1,2", "--key-frame");
  expect_early("-o a.png --key-frame 2:fov=20 --key-frame 1:fov=20", "key frame 2 is not later");
  expect_early("-o a.png --key-frame 1:fov=20 --key-frame 2:height=20", "key frame 2");
  expect_early("-o a.png --isovalue 3", "--isovalue");
  expect_early("-o a.png --mode isosurface", "isovalue");
  expect_early("-o a.png --clip 1,1,1,0,0,0", "clip");
  expect_early("-o a.png --light sun:1,2,3", "--light");
  expect_early("-o a.png --size 30000x30000", "2^28 pixels");
  expect_early("-o a.png --memory 0", "--memory: '0'");
  expect_early("-o a.png --memory 100", "memory");
  expect_early("-o a.png --budget soon", "--budget: 'soon'");
  expect_early("-o a.png --frames 5-2", "--frames");
  expect_early("-o a.png --proxy none.ply", "--proxy none.ply");
  expect_early("-o a.png --proxy bad.ply", "--proxy bad.ply");
  expect_early("-o a.png --gradient-opacity 1,2,3", "--gradient-opacity");
  expect_early("-o a.png --mode maximum --gradient-opacity 0,1", "only mode composite");
  expect_early("-o a.png --mode maximum --classification post", "classification");
  expect_early("-o a.png --octaves 3", "octaves does not apply to this scene");
  expect_error("build - --dims 1000,1000,1000000 --dtype f64 --type u8 -o no/such/a.gvx < /dev/zero",
               "no/such");
  put("s.json", R"({"volume": "-", "raw": {"dims": [1000, 1000, 1000000], "dtype": "u8"}, "function": "x"})");
  expect_error("render s.json -o a.png < /dev/zero", "functions[0]: ");
  expect_error("render sponge --dims 3,3,3 -o a.png", "do not apply to a scene that is made");
  EXPECT_FALSE(fs::exists(path("a.png")));
}

TEST_F(Outputs, an_empty_picture_says_why) {
  write_ball();
  ASSERT_EQ(gvx("build ball_40x36x30_uint8.raw -o ball.gvx").status, 0);
  put("high.json",
      R"([{"RGBPoints": [900, 0, 0, 1, 950, 1, 0, 0], "Points": [900, 0, 0.5, 0, 950, 1, 0.5, 0]}])");
  const auto expect_said = [&](const std::string& flags, const std::string& part) {
    const Outcome outcome = gvx("render ball.gvx --size 24x24 -o a.png --quiet " + flags);
    EXPECT_EQ(outcome.status, 0) << outcome.output;
    EXPECT_NE(outcome.output.find("nothing can be seen: "), std::string::npos) << flags << outcome.output;
    EXPECT_NE(outcome.output.find(part), std::string::npos) << flags << outcome.output;
    EXPECT_EQ(std::count(outcome.output.begin(), outcome.output.end(), '\n'), 1) << outcome.output;
    EXPECT_TRUE(fs::exists(path("a.png")));
    fs::remove(path("a.png"));
  };
  for (const std::string kept : {"", "--transparent ", "--background 1,0.5,0 "}) {
    expect_said(kept + "--mode isosurface --isovalue 5000",
                "isovalue 5000 is outside the volume's values, 0 to ");
    expect_said(kept + "--tf high.json", "is transparent over all of the volume's values, 0 to ");
    expect_said(kept + "--tf high.json", "it shows values above 900");
    expect_said(kept + "--tf high.json --mode maximum", "is transparent over all");
    expect_said(kept + "--clip 2,2,2,3,3,3", "the clip box");
    expect_said(kept + "--camera 'eye=0,-200,0;target=0,-300,0'", "is behind the camera");
    expect_said(kept + "--camera 'eye=0,-200,0;target=300,-200,0'", "looks past the volume");
    expect_said(kept + "--camera 'eye=0,-2000000,0;target=20,18,15'", "is smaller than a pixel");
    expect_said(kept + "--clip 0,0,0,0.05,0.05,0.05", "is transparent");
    expect_said(kept + "--clip 0,0,0,0.05,0.05,0.05 --mode isosurface --isovalue 200",
                "no surface of isovalue 200");
  }
  expect_said("--ambient 0 --diffuse 0 --specular 0 --background 0,0,0", "no light");
  expect_said("--frames 3 --tf high.json && cp a.0001.png a.png; true", "frame 1: nothing can be seen");
  const Outcome seen = gvx("render ball.gvx --size 24x24 -o a.png --quiet");
  EXPECT_EQ(seen.output, "");
}

TEST_F(Outputs, what_is_not_used_is_said) {
  const std::string dims = " - --dims 4,4,4 --dtype u8 ";
  const std::vector<std::string> commands = {"build" + dims + "-o a.gvx --force",
                                             "render" + dims + "-o a.png --size 8x8 --quiet --mode maximum"};
  put("more", std::string(164, 'x'));
  put("much", std::string(2'000'000, 'x'));
  put("exact", std::string(64, 'x'));
  for (const std::string& command : commands) {
    const auto said = [&](const std::string& input) { return gvx(command + input).output; };
    EXPECT_NE(shell("cd '" + folder() + "' && cat more | " GVX_PROGRAM " " + command)
                  .output.find("standard input: 100 more bytes than"),
              std::string::npos);
    // Of a file the size is known before: as with a file's name it must be that of the volume.
    EXPECT_NE(said(" < more").find("standard input: size: expected 64 bytes of data, found 164"),
              std::string::npos);
    EXPECT_NE(shell("cd '" + folder() + "' && cat much | " GVX_PROGRAM " " + command)
                  .output.find("standard input: at least 1048576 more bytes than"),
              std::string::npos);
    EXPECT_NE(said(" < /dev/zero").find("standard input: at least"), std::string::npos);
    EXPECT_EQ(said(" < exact").find("more bytes"), std::string::npos);
  }
  // What a build says a picture says, too.
  std::ofstream file(path("n_4x4x4_float32.raw"), std::ios::binary);
  for (int i = 0; i < 64; ++i) {
    const float v = i == 5 || i == 9 ? NAN : static_cast<float>(i);
    file.write(reinterpret_cast<const char*>(&v), sizeof v);
  }
  file.close();
  const Outcome built = gvx("build n_4x4x4_float32.raw -o n.gvx > /dev/null");
  EXPECT_NE(built.output.find("2 voxels have no value (NaN)"), std::string::npos) << built.output;
  EXPECT_EQ(gvx("render n_4x4x4_float32.raw -o a.png --size 8x8 --quiet").output, built.output);
}

TEST_F(Outputs, a_view_along_z_has_another_up) {
  const std::string render = "render sponge --size 40x40 --quiet ";
  const std::string above = "eye=0.5,0.5,3;target=0.5,0.5,0";
  Outcome outcome = gvx(render + "-o a.png --camera '" + above + "'");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  ASSERT_EQ(gvx(render + "-o b.png --camera '" + above + ";up=0,1,0'").status, 0);
  const auto same = [&] { return shell("cmp '" + path("a.png") + "' '" + path("b.png") + "'").status == 0; };
  EXPECT_TRUE(same());
  expect_error(render + "-o a.png --camera '" + above + ";up=0,0,1'", "up points along the view");
  put("s.json", R"({"volume": "sponge", "camera": {"eye": [0.5, 0.5, 3], "target": [0.5, 0.5, 0]}})");
  ASSERT_EQ(gvx("render s.json --size 40x40 -o a.png --save-scene saved.json").status, 0);
  EXPECT_TRUE(same());
  EXPECT_EQ(read_json("saved.json")["camera"]["up"], (std::vector<double>{0, 1, 0}));
  put("up.json",
      R"({"volume": "sponge", "camera": {"eye": [0.5, 0.5, 3], "target": [0.5, 0.5, 0], "up": [0, 0, 2]}})");
  expect_error("render up.json -o a.png", "up points along the view");
  // Key frames choose their own.
  put("p.json", R"({"volume": "sponge", "size": [40, 40], "camera": {"target": [0.5, 0.5, 0]},
                    "cameraPath": [{"frame": 1, "eye": [0.5, 0.5, 3]}, {"frame": 5, "eye": [0.5, 3.5, 0]},
                                   {"frame": 9, "eye": [0.5, -2.5, 0]}]})");
  outcome = gvx("render p.json -o p.png --frames 1-9 --quiet");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  EXPECT_EQ(shell("cmp '" + path("p.0001.png") + "' '" + path("b.png") + "'").status, 0);
  ASSERT_EQ(gvx(render + "-o c.png --camera 'eye=0.5,3.5,0;target=0.5,0.5,0;up=0,0,1'").status, 0);
  EXPECT_EQ(shell("cmp '" + path("p.0005.png") + "' '" + path("c.png") + "'").status, 0);
  for (const char* way : {"", "--zoom 3"}) {
    outcome = gvx(render + "-o o.png --frames 4 --camera '" + above + "' " + way);
    EXPECT_EQ(outcome.status, 0) << outcome.output;
    EXPECT_EQ(shell("cmp '" + path("o.0001.png") + "' '" + path("b.png") + "'").status, 0);
  }
}

TEST_F(Outputs, hostile_arguments_are_one_line) {
  put(kCube, std::string(4096, 'x'));
  const std::string cube = kCube;
  expect_error("build " + cube + " -o 'no\nsuch/a.gvx'", "no?such");
  expect_error("render 'new\nline.gvx' -o a.png", "new?line.gvx");
  EXPECT_EQ(gvx("render sponge --size 8x8 -o 'new\nline.png' | wc -l").output, "2\n");
  EXPECT_TRUE(fs::exists(path("new\nline.png")));
  expect_error("build " + cube + " -o a.gvx --memory 0", "--memory: '0'");
  expect_error("build " + cube + " -o a.gvx --memory -5", "--memory: '-5'");
  expect_error("build " + cube + " -o ''", "-o : ");
  for (const char* flag : {"--stats ''", "--save-scene ''", "--proxy ''", "--tf ''", "--camera ''"}) {
    expect_error("render sponge -o a.png " + std::string(flag), "expected", 2);
  }
  if (fs::exists("/dev/full")) {
    const Outcome full = gvx("info " + cube + " > /dev/full");
    EXPECT_EQ(full.status, 1);
    EXPECT_NE(full.output.find("standard output: cannot write"), std::string::npos) << full.output;
  }
  EXPECT_EQ(gvx("render --help | head -n 1").output, "Make a picture of a scene\n");
  // A closed stream must not become the picture.
  const Outcome closed = gvx("render sponge --size 8x8 -o closed.png >&-");
  EXPECT_EQ(closed.status, 1);
  EXPECT_NE(closed.output.find("standard output: cannot write"), std::string::npos) << closed.output;
  EXPECT_EQ(io::read_png(path("closed.png")).value().width, 8u);
  // A disk that takes 4 blocks of 512 bytes, as far as this program is concerned.
  const Outcome outcome =
      shell("cd '" + folder() +
            "' && ulimit -f 4 && " GVX_PROGRAM " render sponge -o big.exr --size 256x256 --quiet");
  EXPECT_EQ(outcome.status, 1);
  EXPECT_NE(outcome.output.find("cannot write"), std::string::npos) << outcome.output;
  std::ofstream(path("z_128x128x128_uint8.raw"));
  shell("head -c 2097152 /dev/urandom > '" + path("z_128x128x128_uint8.raw") + "'");
  for (const std::string command :
       {"build z_128x128x128_uint8.raw -o z.gvx", "render z_128x128x128_uint8.raw -o z.png"}) {
    const Outcome limited = shell("cd '" + folder() + "' && ulimit -f 100 && " GVX_PROGRAM " " + command);
    EXPECT_EQ(limited.status, 1);
    EXPECT_NE(limited.output.find("cannot write: "), std::string::npos) << limited.output;
    EXPECT_EQ(limited.output.find("/proc/"), std::string::npos) << limited.output;
  }
  EXPECT_FALSE(fs::exists(path("z.gvx")));
  EXPECT_FALSE(fs::exists(path("z.gvx.partial")));
  if (::geteuid() == 0) return;
  fs::create_directories(path("closed"));
  ::chmod(path("closed").c_str(), 0500);
  expect_error("build " + cube + " -o closed/a.gvx", "closed");
  expect_error("render sponge -o closed/a.png", "closed");
}

}  // namespace
}  // namespace gvx
