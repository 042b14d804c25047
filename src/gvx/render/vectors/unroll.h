/// \file
/// GVX_UNROLL. Private to this room.
#pragma once

/// Before a loop over vectors side by side: what is kept of each stays in registers.
#define GVX_UNROLL _Pragma("GCC unroll 4")
