#include "gvx/io/ome_xml.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include <expat.h>

#include "gvx/io/header_text.h"

namespace gvx::io {
namespace {

constexpr int kMostDepth = 100;

/// Without the prefix of a namespace.
std::string_view local_name(std::string_view name) {
  const std::size_t colon = name.rfind(':');
  return colon == std::string_view::npos ? name : name.substr(colon + 1);
}

class Attributes {
 public:
  explicit Attributes(const XML_Char** attributes) : attributes_(attributes) {}

  std::optional<std::string_view> find(std::string_view name) const {
    for (const XML_Char** a = attributes_; *a != nullptr; a += 2) {
      if (name == local_name(*a)) return std::string_view(a[1]);
    }
    return std::nullopt;
  }
  std::string text(std::string_view name) const { return std::string(find(name).value_or("")); }

 private:
  const XML_Char** attributes_;
};

/// Channel's Color: red, green, blue and alpha as the bytes of a signed number, from the highest.
std::optional<Vec3f> color_of(std::int64_t number) {
  const auto rgba = static_cast<std::uint32_t>(number);
  const auto channel = [&](int shift) { return static_cast<float>(rgba >> shift & 255) / 255; };
  const Vec3f color{channel(24), channel(16), channel(8)};
  if (color.x + color.y + color.z == 0) return std::nullopt;  // black shows nothing
  return color;
}

class OmeParser {
 public:
  explicit OmeParser(XML_Parser parser) : parser_(parser) {
    XML_SetUserData(parser, this);
    XML_SetElementHandler(
        parser,
        [](void* self, const XML_Char* name, const XML_Char** attributes) {
          static_cast<OmeParser*>(self)->start(local_name(name), Attributes(attributes));
        },
        [](void* self, const XML_Char* name) { static_cast<OmeParser*>(self)->end(local_name(name)); });
    XML_SetCharacterDataHandler(parser, [](void* self, const XML_Char* text, int length) {
      static_cast<OmeParser*>(self)->text({text, static_cast<std::size_t>(length)});
    });
    XML_SetStartDoctypeDeclHandler(parser,
                                   [](void* self, const XML_Char*, const XML_Char*, const XML_Char*, int) {
                                     static_cast<OmeParser*>(self)->stop("a document type is not expected");
                                   });
  }

  OmeMetadata metadata;
  std::string wrong;

 private:
  void stop(const std::string& what) {
    if (wrong.empty()) wrong = what;
    XML_StopParser(parser_, XML_FALSE);
  }

  /// Leaves `number` where there is no such attribute.
  template <typename Number>
  void read(const Attributes& attributes, std::string_view name, Number& number, std::int64_t least) {
    const auto text = attributes.find(name);
    if (!text) return;
    const auto value = parse_integer(trimmed(*text));
    if (!value || *value < least) {
      return stop(std::string(name) + ": expected a whole number from " + std::to_string(least) + ", found " +
                  quoted(*text));
    }
    number = *value;
  }

  void start(std::string_view name, const Attributes& a) {
    if (++depth_ > kMostDepth) return stop("elements are nested too deeply");
    if (depth_ == 1) {
      if (name != "OME") return stop("expected the element OME, found " + quoted(name));
      metadata.uuid = a.text("UUID");
    } else if (name == "BinaryOnly") {
      metadata.metadata_file = a.text("MetadataFile");
    } else if (name == "Image" && depth_ == 2) {
      metadata.images.emplace_back().name = a.text("Name");
      has_pixels_ = false;
    } else if (metadata.images.empty()) {
      return;
    } else if (name == "Pixels" && depth_ == 3 && !has_pixels_) {
      has_pixels_ = in_pixels_ = true;
      start_pixels(metadata.images.back(), a);
    } else if (name == "Channel" && in_pixels_) {
      OmeChannel& channel = metadata.images.back().channels.emplace_back();
      channel.name = a.text("Name");
      if (channel.name.empty()) channel.name = a.text("Fluor");
      read(a, "SamplesPerPixel", channel.samples, 1);
      std::int64_t color = -1;
      read(a, "Color", color, INT64_MIN);
      if (a.find("Color")) channel.color = color_of(color);
    } else if (name == "TiffData" && in_pixels_) {
      start_tiff_data(metadata.images.back().data.emplace_back(), a);
    } else if (name == "UUID" && in_pixels_ && !metadata.images.back().data.empty()) {
      in_uuid_ = true;
      metadata.images.back().data.back().file_name = a.text("FileName");
    }
  }

  void start_pixels(OmeImage& image, const Attributes& a) {
    if (const auto order = a.find("DimensionOrder")) image.order = *order;
    std::string sorted = image.order;
    std::sort(sorted.begin(), sorted.end());
    if (!image.order.starts_with("XY") || sorted != "CTXYZ") {
      return stop("DimensionOrder: expected XY and then C, T and Z, found " + quoted(image.order));
    }
    for (const auto& [name, size] : {std::pair{"SizeX", &image.x},
                                     {"SizeY", &image.y},
                                     {"SizeZ", &image.z},
                                     {"SizeC", &image.c},
                                     {"SizeT", &image.t}}) {
      read(a, name, *size, 1);
      if (*size > INT32_MAX) stop(std::string(name) + ": expected at most 2147483647");
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::string name = std::string("PhysicalSize") + "XYZ"[axis];
      if (const auto text = a.find(name)) {
        const auto value = parse_number(trimmed(*text));
        if (value && std::isfinite(*value) && *value > 0) {
          image.spacing[axis] = value;
        } else {
          image.remarks.push_back("OME-XML: " + name + ": expected a number above 0, found " + quoted(*text) +
                                  "; a spacing of 1 is assumed");
        }
      }
      image.unit[axis] = a.text(name + "Unit");
    }
  }

  void start_tiff_data(OmeTiffData& data, const Attributes& a) {
    read(a, "FirstZ", data.z, 0);
    read(a, "FirstC", data.c, 0);
    read(a, "FirstT", data.t, 0);
    read(a, "IFD", data.page, 0);
    if (a.find("IFD")) data.pages = 1;
    read(a, a.find("PlaneCount") ? "PlaneCount" : "NumPlanes", data.pages, 0);
  }

  void end(std::string_view name) {
    --depth_;
    if (name == "Pixels" && depth_ == 2) in_pixels_ = false;
    if (name == "UUID") in_uuid_ = false;
  }

  void text(std::string_view text) {
    if (in_uuid_) metadata.images.back().data.back().uuid += trimmed(text);
  }

  XML_Parser parser_;
  int depth_ = 0;
  bool has_pixels_ = false, in_pixels_ = false, in_uuid_ = false;
};

}  // namespace

bool is_ome_xml(std::string_view text) {
  text = trimmed(text);
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  if (!text.starts_with('<')) return false;
  // The root's name, with or without a prefix, behind comments.
  for (std::size_t at = text.find('<'); at != std::string_view::npos; at = text.find('<', at + 1)) {
    std::string_view tag = text.substr(at + 1, 64);
    if (tag.starts_with('?')) continue;
    if (tag.starts_with("!--")) {
      at = text.find("-->", at);
      if (at == std::string_view::npos) return false;
      continue;
    }
    tag = tag.substr(0, tag.find_first_of(" \t\r\n/>"));
    return local_name(tag) == "OME" || tag.starts_with("!DOCTYPE");
  }
  return false;
}

Result<OmeMetadata> parse_ome_xml(const std::string& path, std::string_view text) {
  const std::unique_ptr<XML_ParserStruct, void (*)(XML_Parser)> parser(XML_ParserCreate(nullptr),
                                                                       XML_ParserFree);
  if (parser == nullptr) return file_error(path, "OME-XML: no memory for a parser");
  OmeParser handler(parser.get());
  constexpr std::size_t kStep = std::size_t{1} << 20;
  for (bool last = false; !last;) {
    const std::string_view part = text.substr(0, kStep);
    text.remove_prefix(part.size());
    last = text.empty();
    if (XML_Parse(parser.get(), part.data(), static_cast<int>(part.size()), last ? 1 : 0) ==
        XML_STATUS_ERROR) {
      const std::string line = std::to_string(XML_GetCurrentLineNumber(parser.get()));
      const std::string what = !handler.wrong.empty()
                                   ? handler.wrong
                                   : std::string(XML_ErrorString(XML_GetErrorCode(parser.get())));
      return file_error(path, "OME-XML, line " + line + ": " + what);
    }
  }
  return std::move(handler.metadata);
}

std::optional<double> micrometres_of(std::string_view unit) {
  constexpr std::pair<std::string_view, double> kUnits[] = {
      {"", 1},         {"\xC2\xB5m", 1},  {"\xCE\xBCm", 1},  {"\xB5m", 1},       {"um", 1},
      {"micron", 1},   {"microns", 1},    {"micrometer", 1}, {"micrometre", 1},  {"micrometers", 1},
      {"\\u00B5m", 1}, {"nm", 1e-3},      {"pm", 1e-6},      {"\xC3\x85", 1e-4}, {"\xE2\x84\xAB", 1e-4},
      {"mm", 1e3},     {"cm", 1e4},       {"dm", 1e5},       {"m", 1e6},         {"km", 1e9},
      {"inch", 25400}, {"inches", 25400}, {"in", 25400}};
  for (const auto& [name, micrometres] : kUnits) {
    if (unit == name) return micrometres;
  }
  return std::nullopt;
}

}  // namespace gvx::io
