#include "progress.h"

#include <cstdio>

#include <unistd.h>

#include "units.h"

namespace gvx::app {

Progress::Progress(std::string what, std::string unit)
    : what_(std::move(what)),
      unit_(std::move(unit)),
      terminal_(isatty(STDERR_FILENO) == 1),
      start_(std::chrono::steady_clock::now()) {}

Progress::~Progress() {
  if (terminal_) std::fputs("\r\033[K", stderr);
}

void Progress::show(std::uint64_t done, std::uint64_t all) {
  const auto now = std::chrono::steady_clock::now();
  if (!terminal_ || all == 0 || now - shown_ < std::chrono::milliseconds(100)) return;
  shown_ = now;
  const double share = static_cast<double>(done) / static_cast<double>(all);
  const double seconds = std::chrono::duration<double>(now - start_).count();
  const double rate = seconds > 0 ? static_cast<double>(done) / seconds : 0;
  const double left = share > 0 ? seconds * (1 - share) / share : 0;
  constexpr int kWidth = 30;
  const int filled = static_cast<int>(share * kWidth);
  const std::string bar = std::string(static_cast<std::size_t>(filled), '#') +
                          std::string(static_cast<std::size_t>(kWidth - filled), '.');
  const std::string speed = unit_.empty() ? bytes_text(static_cast<std::uint64_t>(rate))
                                          : std::to_string(static_cast<long>(rate)) + " " + unit_;
  std::fprintf(stderr, "\r%s [%s] %3.0f%%  %s/s  %.0f s left\033[K", what_.c_str(), bar.c_str(), 100 * share,
               speed.c_str(), left);
  std::fflush(stderr);
}

}  // namespace gvx::app
