/// \file
/// The commands of the program. Each adds itself to the command line; what it returns is run after parsing.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

#include "gvx/core/result.h"

namespace gvx::app {

using Command = std::function<Status()>;

/// gvx info PATH
Command add_info(CLI::App& program);
/// gvx build INPUT -o OUT.gvx
Command add_build(CLI::App& program);
/// gvx render SCENE -o OUT.png
Command add_render(CLI::App& program);
/// gvx verify STORE.gvx
Command add_verify(CLI::App& program);

}  // namespace gvx::app
