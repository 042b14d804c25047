/// \file
/// HelpFormat: how `--help` writes what a flag takes.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace gvx::app {

/// Says in words what CLI11 abbreviates: "1 to 4" for INT:INT in [1 - 4], "not with --budget" for Excludes.
class HelpFormat : public CLI::Formatter {
 public:
  HelpFormat() { label("Positionals", "Arguments"); }
  std::string make_option_name(const CLI::Option* option, bool is_positional) const override;
  std::string make_option_opts(const CLI::Option* option) const override;
  std::string make_option_usage(const CLI::Option* option) const override;
};

}  // namespace gvx::app
