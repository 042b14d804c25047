/// \file
/// The commands of the program. Each adds itself to the command line; what it returns is run after parsing.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>

#include "gvx/core/result.h"

namespace gvx::app {

using Command = std::function<Status()>;

/// For flags that say something if they are there.
inline CLI::Validator not_empty() {
  return CLI::Validator(
      [](std::string& text) {
        return text.empty() ? std::string("expected a text, found nothing") : std::string();
      },
      "");
}

/// gvx info PATH
Command add_info(CLI::App& program);
/// gvx build INPUT -o OUT.gvx
Command add_build(CLI::App& program);
/// gvx render SCENE -o OUT.png
Command add_render(CLI::App& program);
/// gvx verify STORE.gvx
Command add_verify(CLI::App& program);

}  // namespace gvx::app
