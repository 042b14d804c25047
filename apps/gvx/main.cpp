// gvx: one program, a command for each thing it does. Errors are one line on standard error and exit status
// 1; a command line that cannot be understood is exit status 2.

#include <CLI/CLI.hpp>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <map>
#include <new>

#include "commands.h"
#include "messages.h"
#include "signals.h"

namespace gvx::app {
namespace {

int fail(const std::string& message) {
  warn(message);
  return 1;
}

/// What was printed may have gone into a buffer, and be lost only now.
int finish_output(int status) {
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return status;
  return fail(std::string("standard output: cannot write: ") + std::strerror(errno));
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
    if (error.get_exit_code() == 0) return finish_output(program.exit(error));
    warn(std::string(error.what()) + " (gvx --help)");
    return 2;
  }
  const Status status = commands.at(program.get_subcommands().front()->get_name())();
  return status.ok() ? finish_output(0) : fail(status.error().message);
}

}  // namespace
}  // namespace gvx::app

int main(int argc, char** argv) {
  // A reader of our output that goes away is an error of writing, not a signal; so is a file that grows
  // larger than one may be.
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
  try {
    gvx::app::clean_up_on_signals();
    return gvx::app::run(argc, argv);
  } catch (const std::bad_alloc&) {
    return gvx::app::fail("out of memory");
  } catch (const std::exception& error) {
    return gvx::app::fail(error.what());
  }
}
