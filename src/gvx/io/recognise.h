/// \file
/// recognise: what a file or folder is, by its first bytes and, where those do not tell, by its name; and
/// for what gvx does not read, one sentence that says so and what to do instead. The formats are rows of a
/// table (format_table.h).
#pragma once

#include <string>

#include "gvx/core/result.h"

namespace gvx::io {

/// What takes a file.
enum class FileKind {
  unknown,    ///< neither its first bytes nor its name tell
  nrrd,       ///< NRRD, header and data or a header alone
  nifti,      ///< NIfTI-1, NIfTI-2 or Analyze 7.5
  metaimage,  ///< MetaImage
  dicom,      ///< a DICOM file, or a folder of them
  tiff,       ///< a TIFF file, or a folder of them
  raw,        ///< samples without a header, by the name
  mesh,       ///< PLY, OBJ, STL, glTF
  store,      ///< a .gvx store
  other,      ///< known, and read by nothing here
};

struct Recognised {
  FileKind kind = FileKind::unknown;
  bool by_content = false;  ///< otherwise by the name
  bool folder = false;
  /// Why it is not read and what to do, to stand behind "PATH: "; empty for the kinds that are read.
  std::string problem = {};
};

/// Looks at the first 4 KiB, unpacked where they are packed with gzip or bzip2; of a folder, at the names in
/// it. Of what is no regular file, or cannot be read, the name alone says what it is.
Recognised recognise(const std::string& path);

/// What the name alone says.
FileKind kind_by_name(const std::string& path);

/// "PATH: PROBLEM".
Error not_read(const std::string& path, const Recognised& found);

}  // namespace gvx::io
