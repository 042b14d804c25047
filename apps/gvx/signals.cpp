#include "signals.h"

#include <csignal>
#include <string_view>
#include <thread>

#include <pthread.h>
#include <unistd.h>

#include "gvx/core/partial_file.h"

namespace gvx::app {
namespace {

/// Those that the program was not told to ignore, as nohup does, or a shell for jobs in the background.
sigset_t ending_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT}) {
    struct sigaction action {};
    if (sigaction(signal, nullptr, &action) == 0 && action.sa_handler != SIG_IGN) {
      sigaddset(&signals, signal);
    }
  }
  return signals;
}

/// Of a progress bar, in which the terminal's cursor still stands.
void clear_line() {
  constexpr std::string_view kClear = "\r\033[K";
  const ssize_t ignored = write(STDERR_FILENO, kClear.data(), kClear.size());
  (void)ignored;
}

/// A thread, unlike a handler, may wait until a file that is being made has been entered in the list.
void wait_and_end(sigset_t signals) {
  int signal = 0;
  if (sigwait(&signals, &signal) != 0) return;
  remove_partial_files();
  if (isatty(STDERR_FILENO) == 1) clear_line();
  std::signal(signal, SIG_DFL);
  sigset_t this_one;
  sigemptyset(&this_one);
  sigaddset(&this_one, signal);
  pthread_sigmask(SIG_UNBLOCK, &this_one, nullptr);
  kill(getpid(), signal);
}

}  // namespace

void clean_up_on_signals() {
  const sigset_t signals = ending_signals();
  // All threads inherit the mask, so that the signals come to the one that waits for them.
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  std::thread(wait_and_end, signals).detach();
}

}  // namespace gvx::app
