// gvx: one program, a command for each thing it does. An error is one line on standard error. The exit status
// is 1 if a value or a file was refused or the work failed, and 2 if the command line could not be parsed.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <map>
#include <memory>
#include <new>
#include <string>
#include <vector>

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include "command_line.h"
#include "commands.h"
#include "help_format.h"
#include "messages.h"
#include "signals.h"

namespace gvx::app {
namespace {

int fail(const std::string& message) {
  warn(message);
  return 1;
}

/// A standard stream that was closed would become the next file that is opened, and what is printed would go
/// into it. Such a stream fails instead.
void occupy_closed_streams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (fcntl(stream, F_GETFD) >= 0) continue;
    (void)::open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY);
  }
}

bool reader_has_gone() {
  pollfd output{STDOUT_FILENO, 0, 0};
  return poll(&output, 1, 0) > 0 && (output.revents & POLLERR) != 0;
}

/// What was printed may have gone into a buffer, and be lost only now. A reader that has gone, such as
/// `head`, has what it wanted.
int finish_output(int status) {
  const bool failed_before = std::ferror(stdout) != 0;
  if (std::fflush(stdout) == 0 && !failed_before) return status;
  const std::string reason = failed_before ? "" : std::string(": ") + std::strerror(errno);
  return reader_has_gone() ? status : fail("standard output: cannot write" + reason);
}

int run(int argc, char** argv) {
  CLI::App program("Makes pictures of volumes, also of volumes that are bigger than memory.", "gvx");
  program.set_version_flag("--version", "gvx " GVX_VERSION);
  program.formatter(std::make_shared<HelpFormat>());  // before the commands, which take it over
  program.require_subcommand(1);
  program.footer("`gvx COMMAND --help` lists the flags of a command.");
  const std::map<std::string, Command> commands = {{"info", add_info(program)},
                                                   {"build", add_build(program)},
                                                   {"render", add_render(program)},
                                                   {"verify", add_verify(program)}};
  const std::vector<std::string> words(argv + std::min(argc, 1), argv + argc);
  if (const auto unknown = find_unknown_words(program, words)) {
    warn(*unknown);
    return 2;
  }
  try {
    program.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return finish_output(program.exit(error));
    warn(explain(program, error));
    return 2;
  }
  const Status status = commands.at(program.get_subcommands().front()->get_name())();
  return status.ok() ? finish_output(0) : fail(status.error().message);
}

}  // namespace
}  // namespace gvx::app

int main(int argc, char** argv) {
  gvx::app::occupy_closed_streams();
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
