#include "frame_files.h"

#include <algorithm>
#include <charconv>
#include <string_view>

namespace gvx::app {
namespace {

constexpr int kMostFrames = 1'000'000;
constexpr std::size_t kDigits = 4;
constexpr std::string_view kDecimals = "0123456789";

bool parse(std::string_view text, int& frame) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), frame);
  return !text.empty() && error == std::errc{} && end == text.data() + text.size() && frame >= 0 &&
         frame <= kMostFrames;
}

}  // namespace

Result<FrameRange> parse_frames(const std::string& text) {
  FrameRange range;
  const std::size_t dash = text.find('-');
  const bool understood = dash == std::string::npos
                              ? parse(text, range.last)
                              : parse(std::string_view(text).substr(0, dash), range.first) &&
                                    parse(std::string_view(text).substr(dash + 1), range.last);
  if (!understood || range.count() < 1) {
    return Error{"--frames: '" + text + "' is not a number of frames such as 120, or a range such as 10-20"};
  }
  return range;
}

std::string frame_file(const std::string& path, int frame) {
  const auto number = [&](std::size_t digits) {
    const std::string text = std::to_string(frame);
    return std::string(digits - std::min(digits, text.size()), '0') + text;
  };
  const std::size_t percent = path.rfind('%');
  if (percent != std::string::npos) {
    const std::size_t end = std::min(path.find_first_not_of(kDecimals, percent + 1), path.size() - 1);
    if (path[end] == 'd' && end - percent <= 3) {
      int digits = 0;
      std::from_chars(path.data() + percent + 1, path.data() + end, digits);
      return path.substr(0, percent) + number(static_cast<std::size_t>(digits)) + path.substr(end + 1);
    }
  }
  const std::size_t dot = path.rfind('.');
  return path.substr(0, dot) + "." + number(kDigits) + path.substr(dot);
}

}  // namespace gvx::app
