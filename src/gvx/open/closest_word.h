/// \file
/// closest_word: what a mistyped word was most likely meant to be.
#pragma once

#include <optional>
#include <span>
#include <string>

namespace gvx::open {

/// Of these names the one that a mistyped word was most likely meant to be: it begins like no other, or few
/// letters differ (Damerau and Levenshtein's distance of strings). None where no name is near.
std::optional<std::string> closest_word(const std::string& word, std::span<const std::string> names);

}  // namespace gvx::open
