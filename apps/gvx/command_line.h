/// \file
/// What is wrong with a command line, in sentences that name the flag, its value and what was expected.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <span>
#include <string>

namespace gvx::app {

/// Looks at the words behind "gvx" before they are parsed: an unknown command or flag, or a flag without its
/// value. Nothing where all are known.
std::optional<std::string> find_unknown_words(const CLI::App& program, std::span<const std::string> words);

/// An error of the parser in this program's words.
std::string explain(const CLI::App& program, const CLI::ParseError& error);

}  // namespace gvx::app
