/// \file
/// The table of file formats that gvx reads, or knows well enough to say what to do with them.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string_view>

#include "gvx/io/recognise.h"

namespace gvx::io {

/// Bytes that a file of a format has at a place; nothing where `bytes` is empty.
struct Magic {
  std::string_view bytes = {};
  std::size_t at = 0;
};

/// One format. Its sentence is "NAME WHY; INSTEAD".
struct Format {
  FileKind kind;
  std::string_view name;     ///< as the sentence's subject: "VTK image data"
  std::string_view plural;   ///< of files in a folder: "VTK files"
  std::string_view endings;  ///< of names, small, with a space between them
  std::string_view why;      ///< "is not read yet"; empty for formats that are read
  std::string_view instead;  ///< what to do today
  std::array<Magic, 4> magic = {};
  /// Both the first bytes and the name must be the format's: the bytes are those of a container.
  bool needs_both = false;
};

/// In the order in which they are tried: those in a container before the container.
std::span<const Format> formats();

/// Does the head, the first bytes of a file, hold one of the format's marks?
bool has_magic(const Format& format, std::string_view head);

/// Does the name, in small letters and without .gz or .bz2, end as one of the format does?
bool has_ending(const Format& format, std::string_view name);

}  // namespace gvx::io
