/// \file
/// Samples written as decimal text, turned into numbers.
#pragma once

#include <memory>

#include "gvx/io/byte_stream.h"

namespace gvx::io {

/// Numbers between white space or commas, as samples of `type` in native byte order; one that is no number or
/// does not fit the type is an error.
std::unique_ptr<ByteStream> make_ascii_stream(FileSource source, SampleType type);

}  // namespace gvx::io
