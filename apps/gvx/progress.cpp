#include "progress.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <unistd.h>

#include "messages.h"
#include "units.h"

namespace gvx::app {
namespace {

constexpr std::chrono::milliseconds kBarStarts(500), kBarInterval(100);
constexpr std::chrono::seconds kLineInterval(10);
// Rates are over this long at least, and twice this at most.
constexpr std::chrono::seconds kRateSpan(10);
constexpr std::chrono::milliseconds kPointInterval(500);

std::string count_text(double count, const char* unit) {
  const char* prefix = "";
  for (const char* larger : {" thousand", " million", " billion"}) {
    if (count < 1000) break;
    count /= 1000;
    prefix = larger;
  }
  char text[64];
  std::snprintf(text, sizeof(text), count < 10 ? "%.1f%s %s/s" : "%.0f%s %s/s", count, prefix, unit);
  return text;
}

std::string rate_text(double rate, Progress::Unit unit) {
  switch (unit) {
    case Progress::Unit::bytes:
      return bytes_text(static_cast<std::uint64_t>(rate)) + "/s";
    case Progress::Unit::voxels:
      return count_text(rate, "voxels");
    case Progress::Unit::nodes:
      return count_text(rate, "nodes");
    case Progress::Unit::rays:
      return count_text(rate, "rays");
    case Progress::Unit::none:
      break;
  }
  return "";
}

}  // namespace

void Rate::count(Clock::time_point now, std::uint64_t done) {
  // The newest stands for what was counted since the one before it.
  if (points_.size() > 1 && now - points_[points_.size() - 2].time < kPointInterval) points_.pop_back();
  points_.push_back({now, done});
  while (points_.size() > 2 && now - points_[1].time >= kRateSpan) points_.pop_front();
}

double Rate::seconds_since_start() const {
  return std::chrono::duration<double>(points_.back().time - start_).count();
}

std::optional<double> Rate::per_second() const {
  if (seconds_since_start() < 1) return std::nullopt;
  const Point &first = points_.front(), &last = points_.back();
  const double seconds = std::chrono::duration<double>(last.time - first.time).count();
  if (!(seconds > 0) || last.done < first.done) return std::nullopt;
  return static_cast<double>(last.done - first.done) / seconds;
}

std::optional<double> Rate::seconds_left(std::uint64_t all) const {
  const std::optional<double> rate = per_second();
  const std::uint64_t done = points_.back().done;
  if (!rate || done == 0 || seconds_since_start() < 2 || done < all / 100) return std::nullopt;
  // Work that comes in bursts stands still at times: what was done in all counts as much as the newest.
  const double of_all = static_cast<double>(done) / seconds_since_start();
  return static_cast<double>(all - std::min(done, all)) / ((*rate + of_all) / 2);
}

Progress::Progress(std::string what, Unit unit, bool quiet)
    : what_(std::move(what)),
      unit_(unit),
      quiet_(quiet),
      terminal_(isatty(STDERR_FILENO) == 1),
      start_(Rate::Clock::now()),
      shown_(start_),
      rate_(start_) {}

Progress::~Progress() {
  hide();
}

void Progress::hide() {
  if (bar_is_there_) std::fputs("\r\033[K", stderr);
  bar_is_there_ = false;
}

std::string Progress::text(std::uint64_t done, std::uint64_t all) const {
  const double share = all == 0 ? 0 : std::min(1.0, static_cast<double>(done) / static_cast<double>(all));
  // All is not done before the work says so.
  char percent[16];
  std::snprintf(percent, sizeof(percent), "%d%%", static_cast<int>(std::floor(100 * share)));
  std::string text = percent;
  const std::optional<double> rate = rate_.per_second(), left = rate_.seconds_left(all);
  if (rate && unit_ != Unit::none) text += ", " + rate_text(*rate, unit_);
  if (left) text += ", " + duration_text(*left) + " left";
  return text;
}

void Progress::show(std::uint64_t done, std::uint64_t all) {
  const Rate::Clock::time_point now = Rate::Clock::now();
  if (quiet_ || all == 0) return;
  if (now - shown_ < kBarInterval) return;
  rate_.count(now, done);
  if (!terminal_) {
    if (now - shown_ < kLineInterval) return;
    shown_ = now;
    std::fprintf(stderr, "gvx: %s: %s\n", one_line(what_).c_str(), text(done, all).c_str());
    return;
  }
  if (now - start_ < kBarStarts) return;
  shown_ = now;
  constexpr std::size_t kWidth = 30;
  const auto filled = std::min(
      kWidth, static_cast<std::size_t>(kWidth * static_cast<double>(done) / static_cast<double>(all)));
  const std::string bar = std::string(filled, '#') + std::string(kWidth - filled, '.');
  std::fprintf(stderr, "\r%s [%s] %s\033[K", one_line(what_).c_str(), bar.c_str(), text(done, all).c_str());
  std::fflush(stderr);
  bar_is_there_ = true;
}

std::string duration_text(double seconds) {
  if (!(seconds < 1e9)) return "years";
  const auto whole = static_cast<std::int64_t>(std::ceil(seconds));
  char text[64];
  if (whole < 60) {
    std::snprintf(text, sizeof(text), "%d s", static_cast<int>(whole));
  } else if (whole < 3600) {
    std::snprintf(text, sizeof(text), "%d min %02d s", static_cast<int>(whole / 60),
                  static_cast<int>(whole % 60));
  } else {
    std::snprintf(text, sizeof(text), "%lld h %02d min", static_cast<long long>(whole / 3600),
                  static_cast<int>(whole % 3600 / 60));
  }
  return text;
}

}  // namespace gvx::app
