/// \file
/// run_isolated: work by a library that may crash, loop or print on broken input, in a process of its own.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <vector>

namespace gvx::io {

enum class IsolatedOutcome { done, failed, crashed, too_long, no_process };

/// Calls `work` with `out.size()` bytes to write to, in a fork of this process, and copies them to `out`
/// where it returns true. What it prints is lost. `work` must not wait for other threads, which the fork does
/// not have. The fork ends after `limit`.
IsolatedOutcome run_isolated(std::vector<std::byte>& out, std::chrono::seconds limit,
                             const std::function<bool(std::byte*)>& work);

}  // namespace gvx::io
