/// \file
/// ProgramTest: runs the program as a user does, in a folder of its own.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include <gtest/gtest.h>
#include <sys/wait.h>

#include "gvx/core/macros.h"

namespace gvx {

struct Outcome {
  int status = 0;
  std::string output;  // both streams
};

/// Runs a shell command; a signal is status 128 + its number.
inline Outcome shell(const std::string& command) {
  Outcome outcome;
  FILE* pipe = popen(("{ " + command + " ; } 2>&1").c_str(), "r");
  GVX_CHECK(pipe != nullptr);
  std::array<char, 4096> buffer;
  while (const std::size_t got = fread(buffer.data(), 1, buffer.size(), pipe))
    outcome.output.append(buffer.data(), got);
  const int status = pclose(pipe);
  outcome.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return outcome;
}

class ProgramTest : public testing::Test {
 protected:
  /// The folder is called `name`.
  explicit ProgramTest(const std::string& name) : folder_(testing::TempDir() + name) {}

  void SetUp() override {
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  Outcome gvx(const std::string& arguments) const {
    return shell("cd '" + folder_ + "' && timeout 120 " GVX_PROGRAM " " + arguments);
  }
  /// Runs it and expects one line of error with this in it, and the exit status.
  void expect_error(const std::string& arguments, const std::string& part, int status = 1) const {
    const Outcome outcome = gvx(arguments);
    EXPECT_EQ(outcome.status, status) << arguments << "\n" << outcome.output;
    EXPECT_NE(outcome.output.find(part), std::string::npos) << arguments << "\n" << outcome.output;
    EXPECT_EQ(outcome.output.rfind("gvx: ", 0), 0u) << outcome.output;
    EXPECT_EQ(std::count(outcome.output.begin(), outcome.output.end(), '\n'), 1) << outcome.output;
  }
  const std::string& folder() const { return folder_; }
  std::string path(const std::string& name) const { return folder_ + "/" + name; }
  /// A raw ball of 40 x 36 x 30 u8 voxels.
  std::string write_ball(const std::string& name = "ball_40x36x30_uint8.raw") const {
    std::ofstream file(path(name), std::ios::binary);
    for (int z = 0; z < 30; ++z) {
      for (int y = 0; y < 36; ++y) {
        for (int x = 0; x < 40; ++x) {
          const double r = std::hypot(std::hypot(x - 19.5, y - 17.5), z - 14.5);
          file.put(static_cast<char>(std::max(0.0, 250 - 16 * r)));
        }
      }
    }
    return name;
  }
  nlohmann::json read_json(const std::string& name) const {
    std::ifstream file(path(name));
    return nlohmann::json::parse(file);
  }

 private:
  std::string folder_;
};

}  // namespace gvx
