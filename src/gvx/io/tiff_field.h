/// \file
/// A field of the page that libtiff stands at.
#pragma once

#include <tiffio.h>

namespace gvx::io {

/// The tag's value or its default, or `otherwise` where it has neither. T is what libtiff writes for the tag.
template <typename T>
T tiff_field(TIFF* tiff, ttag_t tag, T otherwise) {
  T value = otherwise;
  return TIFFGetFieldDefaulted(tiff, tag, &value) == 1 ? value : otherwise;
}

}  // namespace gvx::io
