// gvx verify STORE.gvx: checks that a store is undamaged.

#include "gvx/store/verify.h"

#include <cstdio>

#include "commands.h"
#include "gvx/surface/surface_reader.h"
#include "messages.h"
#include "progress.h"
#include "units.h"

namespace gvx::app {

namespace {

Status verify_surface_store(const std::string& path) {
  surface::SurfaceVerifyReport report;
  {
    Progress progress("verifying", Progress::Unit::nodes);
    GVX_ASSIGN(report, surface::verify_surface(
                           path, [&](std::uint64_t done, std::uint64_t all) { progress.show(done, all); }));
  }
  std::printf("%s: sound: a surface of %llu bricks, %llu samples and %llu triangles, %s read\n",
              one_line(path).c_str(), static_cast<unsigned long long>(report.nodes),
              static_cast<unsigned long long>(report.samples),
              static_cast<unsigned long long>(report.triangles), bytes_text(report.bytes_read).c_str());
  return {};
}

}  // namespace

Command add_verify(CLI::App& program) {
  auto path = std::make_shared<std::string>();
  auto threads = std::make_shared<int>(0);
  CLI::App* command =
      program.add_subcommand("verify", "Check a store for damage: every brick, index page and section");
  command->add_option("store", *path, "The store, a .gvx file")->required();
  command->add_option("--threads", *threads, "Number of threads; 0: all cores")->check(CLI::Range(0, 1024));
  return [path, threads]() -> Status {
    if (surface::is_surface_store(*path)) return verify_surface_store(*path);
    store::VerifyReport report;
    {
      Progress progress("verifying", Progress::Unit::nodes);
      GVX_ASSIGN(report,
                 store::verify(exec::Device::cpu(*threads), *path,
                               [&](std::uint64_t done, std::uint64_t all) { progress.show(done, all); }));
    }
    std::printf("%s: sound: %llu bricks and %llu constant nodes, %s read\n", one_line(*path).c_str(),
                static_cast<unsigned long long>(report.bricks),
                static_cast<unsigned long long>(report.constant_nodes),
                bytes_text(report.bytes_read).c_str());
    return {};
  };
}

}  // namespace gvx::app
