#include "gvx/io/isolated.h"

#include <cerrno>
#include <csignal>
#include <cstring>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace gvx::io {
namespace {

/// What the fork does; never returns.
[[noreturn]] void work_and_exit(std::byte* shared, std::chrono::seconds limit,
                                const std::function<bool(std::byte*)>& work) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGABRT, SIGSEGV, SIGBUS, SIGFPE, SIGALRM}) {
    std::signal(signal, SIG_DFL);
  }
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  const rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
  const int nothing = open("/dev/null", O_WRONLY | O_CLOEXEC);
  if (nothing >= 0) {
    dup2(nothing, STDOUT_FILENO);
    dup2(nothing, STDERR_FILENO);
  }
  alarm(static_cast<unsigned>(limit.count()));
  bool done = false;
  try {
    done = work(shared);
  } catch (...) {
    done = false;
  }
  _exit(done ? 0 : 1);
}

}  // namespace

IsolatedOutcome run_isolated(std::vector<std::byte>& out, std::chrono::seconds limit,
                             const std::function<bool(std::byte*)>& work) {
  void* const shared = mmap(nullptr, out.size(), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (shared == MAP_FAILED) return IsolatedOutcome::no_process;
  const pid_t child = fork();
  if (child == 0) work_and_exit(static_cast<std::byte*>(shared), limit, work);
  int status = 0;
  bool ended = child > 0;
  while (ended && waitpid(child, &status, 0) < 0) ended = errno == EINTR;
  const bool done = ended && WIFEXITED(status) && WEXITSTATUS(status) == 0;
  if (done) std::memcpy(out.data(), shared, out.size());
  munmap(shared, out.size());
  if (!ended) return IsolatedOutcome::no_process;
  if (done) return IsolatedOutcome::done;
  if (WIFSIGNALED(status)) {
    return WTERMSIG(status) == SIGALRM ? IsolatedOutcome::too_long : IsolatedOutcome::crashed;
  }
  return IsolatedOutcome::failed;
}

}  // namespace gvx::io
