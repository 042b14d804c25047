// gvx: one program, a command for each thing it does. Errors are one line on standard error and exit status
// 1; a command line that cannot be understood is exit status 2.

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <exception>
#include <map>
#include <new>

#include "commands.h"

namespace gvx::app {
namespace {

int fail(const std::string& message) {
  std::fprintf(stderr, "gvx: %s\n", message.c_str());
  return 1;
}

int run(int argc, char** argv) {
  CLI::App program("Renders volumes far bigger than memory: rays decide what is loaded.", "gvx");
  program.set_version_flag("--version", "gvx " GVX_VERSION);
  program.require_subcommand(1);
  program.footer("`gvx COMMAND --help` tells more of each.");
  const std::map<std::string, Command> commands = {{"info", add_info(program)},
                                                   {"build", add_build(program)},
                                                   {"render", add_render(program)},
                                                   {"verify", add_verify(program)}};
  try {
    program.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return program.exit(error);
    std::fprintf(stderr, "gvx: %s (gvx --help)\n", error.what());
    return 2;
  }
  const Status status = commands.at(program.get_subcommands().front()->get_name())();
  return status.ok() ? 0 : fail(status.error().message);
}

}  // namespace
}  // namespace gvx::app

int main(int argc, char** argv) {
  // A reader of our output that goes away is an error of writing, not a signal.
  std::signal(SIGPIPE, SIG_IGN);
  try {
    return gvx::app::run(argc, argv);
  } catch (const std::bad_alloc&) {
    return gvx::app::fail("out of memory");
  } catch (const std::exception& error) {
    return gvx::app::fail(error.what());
  }
}
