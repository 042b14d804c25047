/// \file
/// UpAxis: which axis of the world points up.
#pragma once

#include <cstdint>

namespace gvx {

enum class UpAxis : std::uint32_t { y, z };

/// The names of UpAxis, in its order.
inline constexpr const char* kUpAxisNames[] = {"y", "z"};

}  // namespace gvx
