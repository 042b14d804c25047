/// \file
/// Why a picture shows nothing.
#pragma once

#include <optional>
#include <string>

#include "gvx/produce/producer.h"
#include "gvx/render/frame/film.h"
#include "gvx/render/frame/view.h"

namespace gvx::open {

/// One sentence that says why nothing can be seen in the picture; nothing where something can, or where a
/// preview (not `exact`) may only lack the data. With a `proxy` rays are cut by a mesh as well.
std::optional<std::string> why_nothing_is_seen(const render::Picture& picture, const render::View& view,
                                               const produce::TreeDescription& tree, bool exact, bool proxy);

}  // namespace gvx::open
