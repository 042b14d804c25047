/// \file
/// Signals that end the program: Ctrl-C and its like leave no unfinished file behind.
#pragma once

namespace gvx::app {

/// From now on SIGINT, SIGTERM, SIGHUP and SIGQUIT remove unfinished files before they end the program; its
/// exit status is that of the signal. Those that the program was started to ignore stay ignored. To be called
/// before any other thread begins.
void clean_up_on_signals();

}  // namespace gvx::app
