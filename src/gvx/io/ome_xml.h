/// \file
/// OME-XML (Open Microscopy Environment, schemas 2007-06 to 2016-06): what it says of the pixels of an
/// OME-TIFF file. Parsed by expat as a stream. Document types, and so entities of one's own, are refused.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "gvx/core/result.h"
#include "gvx/core/vec.h"

namespace gvx::io {

struct OmeChannel {
  std::string name;
  std::optional<Vec3f> color;
  std::int64_t samples = 1;  ///< SamplesPerPixel.
};

/// A TiffData element: which pages of which file are planes.
struct OmeTiffData {
  std::int64_t z = 0, c = 0, t = 0;   ///< The plane of the first of the pages.
  std::int64_t page = 0;              ///< IFD, from 0.
  std::optional<std::int64_t> pages;  ///< How many; if not said, one or, without an IFD, all.
  std::string uuid, file_name;        ///< Empty: the file that holds the XML.
};

/// An Image element with its Pixels.
struct OmeImage {
  std::string name;
  std::string order = "XYCZT";  ///< Fastest axis first.
  std::int64_t x = 0, y = 0, z = 1, c = 1, t = 1;
  std::array<std::optional<double>, 3> spacing;  ///< Along x, y and z.
  std::array<std::string, 3> unit;               ///< UTF-8; the schema's default is micrometres.
  std::vector<OmeChannel> channels;
  std::vector<OmeTiffData> data;
  std::vector<std::string> remarks;  ///< Attributes that say nothing usable, and what is assumed instead.
};

struct OmeMetadata {
  std::string uuid;           ///< Of the file that holds the XML.
  std::string metadata_file;  ///< Where a file has no more than BinaryOnly: the one with the metadata.
  std::vector<OmeImage> images;
};

/// Is this the beginning of an OME-XML document?
bool is_ome_xml(std::string_view text);

/// Messages name `path`. An error where the text is not well-formed or has numbers that are none.
Result<OmeMetadata> parse_ome_xml(const std::string& path, std::string_view text);

/// Micrometres of one unit of length as OME-XML and ImageJ write them ("nm", "µm", "micron", "mm", ..);
/// nothing for others, such as "pixel" or "inch ".
std::optional<double> micrometres_of(std::string_view unit);

}  // namespace gvx::io
