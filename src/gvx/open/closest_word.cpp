#include "gvx/open/closest_word.h"

#include <algorithm>
#include <numeric>
#include <string_view>
#include <vector>

namespace gvx::open {
namespace {

/// Letters to add, take away, change or swap with their neighbours to get from one word to the other.
std::size_t distance(std::string_view a, std::string_view b) {
  std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) d[i][0] = i;
  std::iota(d[0].begin(), d[0].end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    for (std::size_t j = 1; j <= b.size(); ++j) {
      d[i][j] =
          std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
      }
    }
  }
  return d[a.size()][b.size()];
}

}  // namespace

std::optional<std::string> closest_word(const std::string& word, std::span<const std::string> names) {
  std::vector<std::string> longer;
  for (const std::string& name : names) {
    if (word.size() > 3 && name.starts_with(word)) longer.push_back(name);
  }
  if (longer.size() == 1) return longer.front();
  const std::size_t letters = word.size() - std::min(word.find_first_not_of('-'), word.size());
  std::size_t least = letters / 3 + 1;
  std::optional<std::string> near;
  for (const std::string& name : names) {
    const std::size_t d = distance(word, name);
    // Of two letters every other word is near.
    if (d < least + (letters > 2 ? 1 : 0) && (!near || d < distance(word, *near))) near = name;
  }
  return near;
}

}  // namespace gvx::open
