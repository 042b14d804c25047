/// \file
/// The limits of numbers in scene files that several fields share. Private to this room.
#pragma once

#include "gvx/scene/json_fields.h"

namespace gvx::scene {

inline constexpr NumberRange kAny{};
inline constexpr NumberRange kShare{0, 1};
inline constexpr NumberRange kAboveZero{.least = 0, .open = true};
inline constexpr NumberRange kWeight{0, 100};

}  // namespace gvx::scene
