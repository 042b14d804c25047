#include "gvx/io/mesh_ply.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <memory>
#include <optional>
#include <vector>

#include "gvx/io/byte_stream.h"
#include "gvx/io/header_text.h"
#include "gvx/io/sample_type.h"
#include "gvx/io/text_scanner.h"

namespace gvx::io {
namespace {

enum class PlyFormat { text, little, big };

/// One number, or a list of them behind its count.
struct Property {
  std::string name;
  SampleType type = SampleType::f32;
  std::optional<SampleType> count_type;
};

struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;
};

struct Header {
  PlyFormat format = PlyFormat::text;
  std::vector<Element> elements;
};

Result<SampleType> sample_type(const TextScanner& in, std::string_view name) {
  // As old files say it.
  const auto type = parse_sample_type(name);
  if (!type) return in.error("property of type " + quoted(name) + ", which PLY does not have");
  return *type;
}

Status parse_property(const TextScanner& in, const std::vector<std::string_view>& line, Header& header) {
  if (header.elements.empty()) return in.error("a property before any element");
  Property property;
  const bool list = line.size() == 5 && line[1] == "list";
  if (!list && line.size() != 3) return in.error("a property line that is not understood");
  if (list) {
    GVX_ASSIGN(property.count_type, sample_type(in, line[2]));
  }
  GVX_ASSIGN(property.type, sample_type(in, line[line.size() - 2]));
  property.name = line.back();
  header.elements.back().properties.push_back(std::move(property));
  return {};
}

/// The next number in the file's format.
Result<double> read_number(TextScanner& in, PlyFormat format, SampleType type) {
  if (format == PlyFormat::text) return in.number();
  std::array<std::byte, 8> bytes{};
  const std::span<std::byte> used(bytes.data(), sample_bytes(type));
  GVX_TRY(in.read(used));
  if (format == PlyFormat::big) std::reverse(used.begin(), used.end());
  return with_sample_type(type, [&](auto value) {
    std::memcpy(&value, bytes.data(), sizeof(value));
    return Result<double>(static_cast<double>(value));
  });
}

/// A header's lines. All end as the first does: behind the last come any bytes.
class HeaderLines {
 public:
  explicit HeaderLines(TextScanner& in) : in_(in) {}

  Result<std::string> next() {
    std::string text;
    GVX_ASSIGN(const std::optional<char> end, in_.line_until(ends_, text, kMaximumHeaderBytes));
    if (!end) return in_.error("ends early");
    if (ends_.size() > 1) {
      GVX_ASSIGN(const std::optional<char> after, in_.peek());
      std::byte byte{};
      if (end == '\r' && after == '\n') GVX_TRY(in_.read({&byte, 1}));
      ends_ = end == '\r' && after != '\n' ? "\r" : "\n";
    }
    if (text.ends_with('\r')) text.pop_back();
    return text;
  }

 private:
  TextScanner& in_;
  std::string_view ends_ = "\n\r";
};

Result<Header> read_header(TextScanner& in) {
  Header header;
  HeaderLines lines(in);
  GVX_ASSIGN(const std::string magic, lines.next());
  if (trimmed(magic) != "ply") return in.error("not a PLY file: it does not begin with \"ply\"");
  bool has_format = false;
  std::size_t bytes = 0;
  while (true) {
    GVX_ASSIGN(const std::string text, lines.next());
    bytes += text.size() + 1;
    if (bytes > kMaximumHeaderBytes) return in.error("its header does not end");
    const auto line = words(text);
    if (line.empty() || line[0] == "comment" || line[0] == "obj_info") continue;
    if (line[0] == "end_header") break;
    if (line[0] == "format" && line.size() >= 2) {
      has_format = true;
      if (line[1] == "ascii") {
        header.format = PlyFormat::text;
      } else if (line[1] == "binary_little_endian") {
        header.format = PlyFormat::little;
      } else if (line[1] == "binary_big_endian") {
        header.format = PlyFormat::big;
      } else {
        return in.error("format " + quoted(line[1]) + ", which PLY does not have");
      }
    } else if (line[0] == "element" && line.size() == 3) {
      const auto count = parse_integer(line[2]);
      if (!count || *count < 0) return in.error("element of " + quoted(line[2]) + " items");
      header.elements.push_back({std::string(line[1]), static_cast<std::uint64_t>(*count), {}});
    } else if (line[0] == "property") {
      GVX_TRY(parse_property(in, line, header));
    } else {
      return in.error("header line " + quoted(text) + " is not understood");
    }
  }
  if (!has_format) return in.error("its header names no format");
  return header;
}

/// What an item of it takes at least: an absurd count shows before anything is allocated.
std::uint64_t least_bytes(const Element& element, PlyFormat format) {
  std::uint64_t bytes = 0;
  for (const Property& p : element.properties) {
    bytes += format == PlyFormat::text ? 2 : sample_bytes(p.count_type.value_or(p.type));
  }
  return bytes;
}

/// A colour's numbers as files have them: bytes, words, or 0 to 1.
float color_share(double value, SampleType type) {
  if (type == SampleType::u16)
    value /= 65535;
  else if (type != SampleType::f32 && type != SampleType::f64)
    value /= 255;
  return std::isfinite(value) ? static_cast<float>(std::clamp(value, 0.0, 1.0)) : 0.0f;
}

/// Where an element has numbers that belong together, such as x, y and z.
class Triple {
 public:
  Triple(const Element& element, const std::array<const char*, 3>& names) {
    for (std::size_t i = 0; i < element.properties.size(); ++i) {
      const Property& p = element.properties[i];
      for (std::size_t k = 0; k < 3; ++k) {
        if (p.name == names[k] && !p.count_type) at_[k] = i;
      }
    }
  }

  bool there() const {
    return std::all_of(at_.begin(), at_.end(), [](const auto& at) { return at.has_value(); });
  }

  /// Which of the three a property is.
  std::optional<std::size_t> part(std::size_t property) const {
    for (std::size_t k = 0; k < 3; ++k) {
      if (there() && at_[k] == property) return k;
    }
    return {};
  }

 private:
  std::array<std::optional<std::size_t>, 3> at_;
};

Triple colors_of(const Element& element) {
  const Triple plain(element, {"red", "green", "blue"});
  return plain.there() ? plain : Triple(element, {"diffuse_red", "diffuse_green", "diffuse_blue"});
}

/// What a property is that a picture could show and that is not used; null for others.
const char* worth_a_word(const Property& p) {
  for (const char* name : {"s", "t", "u", "v", "texture_u", "texture_v", "texcoord"}) {
    if (p.name == name) return "texture coordinates";
  }
  return nullptr;
}

class PlyReader {
 public:
  PlyReader(std::unique_ptr<ByteStream> stream, MeshSink& sink, const MeshProgress& progress)
      : in_(std::move(stream)), sink_(sink), progress_(progress) {}

  Status read() {
    GVX_ASSIGN(header_, read_header(in_));
    GVX_TRY(check_order());
    for (const Element& element : header_.elements) {
      const std::uint64_t least = least_bytes(element, header_.format);
      if (const auto left = in_.bytes_left(); left && least > 0 && element.count > *left / least + 1) {
        return in_.error("is too short for " + std::to_string(element.count) + " of " + quoted(element.name));
      }
      if (element.name == "vertex") {
        GVX_TRY(read_vertices(element));
      } else if (element.name == "face") {
        GVX_TRY(read_faces(element));
      } else if (element.name == "tristrips") {
        GVX_TRY(read_strips(element));
      } else {
        if (element.name == "edge" && element.count > 0) sink_.pass_over("lines");
        for (std::uint64_t i = 0; i < element.count && !element.properties.empty(); ++i) {
          for (const Property& p : element.properties) GVX_TRY(pass(p));
        }
      }
    }
    return {};
  }

 private:
  static bool has_surface(const Element& element) {
    return element.name == "face" || element.name == "tristrips";
  }
  static bool is_index_list(const Property& p) {
    return p.count_type && (p.name == "vertex_indices" || p.name == "vertex_index");
  }

  Result<double> number(SampleType type) { return read_number(in_, header_.format, type); }

  Result<std::uint32_t> list_count(const Property& p, double most) {
    GVX_ASSIGN(const double count, number(*p.count_type));
    if (!(count >= 0 && count <= most && count == std::floor(count))) {
      return in_.error("a list of " + std::to_string(count) + " items");
    }
    return static_cast<std::uint32_t>(count);
  }

  Status pass(const Property& p) {
    std::uint32_t count = 1;
    if (p.count_type) {
      GVX_ASSIGN(count, list_count(p, kMostCorners));
    }
    for (std::uint32_t i = 0; i < count; ++i) GVX_TRY(number(p.type));
    return {};
  }

  /// Triangles are handed over as they come, and so must be of vertices that are known.
  Status check_order() {
    int vertices = 0;
    for (const Element& element : header_.elements) {
      if (element.name == "vertex" && ++vertices > 1) return in_.error("has vertices in two places");
      if (has_surface(element) && vertices == 0) return in_.error("has faces before its vertices");
      if (element.name == "vertex" || has_surface(element)) all_ += element.count;
      if (element.name != "vertex" && element.name != "face") continue;
      for (const Property& p : element.properties) {
        if (const char* what = worth_a_word(p)) sink_.pass_over(what);
      }
    }
    return {};
  }

  /// After each vertex or polygon: hands on what waits, if it is much.
  Status count_one() {
    ++done_;
    constexpr std::size_t kMany = 1 << 14;
    if (places_.size() < kMany && triangles_.size() < kMany) return {};
    return hand_on();
  }

  Status hand_on() {
    if (!places_.empty()) GVX_TRY(sink_.add_vertices(places_, colors_));
    if (!triangles_.empty()) GVX_TRY(sink_.add_triangles(triangles_, colors_));
    places_.clear();
    colors_.clear();
    triangles_.clear();
    if (progress_) progress_(done_, all_);
    return {};
  }

  Status read_vertices(const Element& element) {
    if (element.count > UINT32_MAX - 1) return in_.error("has more vertices than 32 bits can count");
    const Triple place(element, {"x", "y", "z"}), color = colors_of(element);
    if (!place.there()) return in_.error("its vertices have no x, y and z");
    has_vertex_colors_ = color.there();
    for (std::uint64_t i = 0; i < element.count; ++i) {
      Vec3d at;
      Vec3f shown;
      for (std::size_t k = 0; k < element.properties.size(); ++k) {
        const Property& p = element.properties[k];
        if (const auto axis = place.part(k)) {
          GVX_ASSIGN(at[static_cast<int>(*axis)], number(p.type));
        } else if (const auto channel = color.part(k)) {
          GVX_ASSIGN(const double value, number(p.type));
          shown[static_cast<int>(*channel)] = color_share(value, p.type);
        } else {
          GVX_TRY(pass(p));
        }
      }
      places_.push_back(at);
      if (color.there()) colors_.push_back(shown);
      GVX_TRY(count_one());
    }
    return hand_on();
  }

  Status read_faces(const Element& element) {
    const Triple color = colors_of(element);
    const bool colored = color.there() && !has_vertex_colors_;
    if (color.there() && !colored) sink_.pass_over("colours of faces (those of vertices are shown)");
    for (std::uint64_t i = 0; i < element.count && !element.properties.empty(); ++i) {
      Vec3f shown;
      for (std::size_t k = 0; k < element.properties.size(); ++k) {
        const Property& p = element.properties[k];
        if (is_index_list(p)) {
          GVX_TRY(read_face(p));
        } else if (const auto channel = color.part(k)) {
          GVX_ASSIGN(const double value, number(p.type));
          shown[static_cast<int>(*channel)] = color_share(value, p.type);
        } else {
          GVX_TRY(pass(p));
        }
      }
      if (colored) colors_.resize(triangles_.size(), shown);
      GVX_TRY(count_one());
    }
    return hand_on();
  }

  Result<std::uint32_t> read_index(const Property& p) {
    GVX_ASSIGN(const double value, number(p.type));
    if (!(value >= 0 && value < static_cast<double>(UINT32_MAX))) {
      return in_.error("a face of a vertex that is not there");
    }
    return static_cast<std::uint32_t>(value);
  }

  Status read_face(const Property& p) {
    GVX_ASSIGN(const std::uint32_t count, list_count(p, kMostCorners));
    corners_.clear();
    for (std::uint32_t k = 0; k < count; ++k) {
      GVX_ASSIGN(const std::uint32_t vertex, read_index(p));
      corners_.push_back(vertex);
    }
    return cut_polygon(sink_, corners_, triangles_);
  }

  /// Lists in which each vertex makes a triangle with the two before it; -1 begins anew.
  Status read_strips(const Element& element) {
    for (std::uint64_t i = 0; i < element.count && !element.properties.empty(); ++i) {
      for (const Property& p : element.properties) {
        if (is_index_list(p)) {
          GVX_TRY(read_strip(p));
        } else {
          GVX_TRY(pass(p));
        }
      }
      ++done_;
    }
    return hand_on();
  }

  Status read_strip(const Property& p) {
    GVX_ASSIGN(const std::uint32_t count, list_count(p, UINT32_MAX));
    std::array<std::uint32_t, 2> before{};
    std::uint32_t in_strip = 0;
    for (std::uint32_t k = 0; k < count; ++k) {
      GVX_ASSIGN(const double value, number(p.type));
      if (value == -1) {
        in_strip = 0;
        continue;
      }
      if (!(value >= 0 && value < static_cast<double>(UINT32_MAX))) {
        return in_.error("a strip of a vertex that is not there");
      }
      const auto vertex = static_cast<std::uint32_t>(value);
      if (in_strip >= 2) {
        const bool odd = in_strip % 2 != 0;
        triangles_.push_back({before[odd ? 1 : 0], before[odd ? 0 : 1], vertex});
        if (triangles_.size() == 1 << 14) GVX_TRY(hand_on());
      }
      before = {before[1], vertex};
      ++in_strip;
    }
    return {};
  }

  /// Of a polygon.
  static constexpr double kMostCorners = 1e6;

  TextScanner in_;
  MeshSink& sink_;
  const MeshProgress& progress_;
  Header header_;
  std::uint64_t done_ = 0, all_ = 0;
  bool has_vertex_colors_ = false;
  std::vector<Vec3d> places_;
  std::vector<Vec3f> colors_;  // of what waits: vertices or triangles
  std::vector<Triangle> triangles_;
  std::vector<std::uint32_t> corners_;
};

}  // namespace

Status stream_ply(const std::string& path, MeshSink& sink, const MeshProgress& progress) {
  const Encoding encoding = lower_case(path).ends_with(".gz") ? Encoding::gzip : Encoding::raw;
  GVX_ASSIGN(auto stream, open_byte_stream(path, encoding, {}, SampleType::u8));
  return PlyReader(std::move(stream), sink, progress).read();
}

}  // namespace gvx::io
