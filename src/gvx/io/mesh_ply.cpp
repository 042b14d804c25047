#include "gvx/io/mesh_ply.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <optional>

#include "gvx/io/byte_stream.h"
#include "gvx/io/header_text.h"

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

/// The file's bytes, lines, words and numbers in order.
class Scanner {
 public:
  explicit Scanner(std::unique_ptr<ByteStream> stream) : stream_(std::move(stream)) {}

  Error error(const std::string& message) const { return file_error(stream_->name(), message); }

  /// Fills `out`; an error where the file ends first.
  Status read(std::span<std::byte> out) {
    while (!out.empty()) {
      if (begin_ == end_) {
        GVX_TRY(refill());
        if (end_ == 0) return error("ends early");
      }
      const std::size_t count = std::min(out.size(), end_ - begin_);
      std::memcpy(out.data(), buffer_.data() + begin_, count);
      begin_ += count;
      out = out.subspan(count);
    }
    return {};
  }

  /// Without its end.
  Result<std::string> line() {
    std::string text;
    while (true) {
      std::byte byte{};
      GVX_TRY(read({&byte, 1}));
      if (byte == std::byte{'\n'}) break;
      if (text.size() == kMaximumHeaderBytes) return error("a line of the header does not end");
      text.push_back(static_cast<char>(byte));
    }
    if (text.ends_with('\r')) text.pop_back();
    return text;
  }

  /// The next number of text.
  Result<double> number() {
    std::string text;
    while (true) {
      std::byte byte{};
      const Status got = read({&byte, 1});
      const bool blank = !got.ok() || byte == std::byte{' '} || byte == std::byte{'\n'} ||
                         byte == std::byte{'\t'} || byte == std::byte{'\r'};
      if (!got.ok() && text.empty()) return got.error();
      if (blank && text.empty()) continue;
      if (blank) break;
      if (text.size() == 64) return error("'" + quoted(text) + "' is no number");
      text.push_back(static_cast<char>(byte));
    }
    const auto value = parse_number(text);
    if (!value) return error(quoted(text) + " is no number");
    return *value;
  }

  /// The next number in the file's format.
  Result<double> number(PlyFormat format, SampleType type) {
    if (format == PlyFormat::text) return number();
    std::array<std::byte, 8> bytes{};
    const std::span<std::byte> used(bytes.data(), sample_bytes(type));
    GVX_TRY(read(used));
    if (format == PlyFormat::big) std::reverse(used.begin(), used.end());
    return with_sample_type(type, [&](auto value) {
      std::memcpy(&value, bytes.data(), sizeof(value));
      return Result<double>(static_cast<double>(value));
    });
  }

  /// Of the file from here on, where its size is known.
  std::optional<std::uint64_t> bytes_left() const {
    const auto left = stream_->bytes_left();
    return left ? std::optional(*left + (end_ - begin_)) : std::nullopt;
  }

 private:
  Status refill() {
    buffer_.resize(1 << 16);
    begin_ = end_ = 0;
    GVX_ASSIGN(end_, stream_->read(buffer_));
    return {};
  }

  std::unique_ptr<ByteStream> stream_;
  std::vector<std::byte> buffer_;
  std::size_t begin_ = 0, end_ = 0;
};

Result<SampleType> sample_type(const Scanner& in, std::string_view name) {
  // As old files say it.
  const auto type = parse_sample_type(name);
  if (!type) return in.error("property of type " + quoted(name) + ", which PLY does not have");
  return *type;
}

Status parse_property(const Scanner& in, const std::vector<std::string_view>& line, Header& header) {
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

Result<Header> read_header(Scanner& in) {
  Header header;
  GVX_ASSIGN(const std::string magic, in.line());
  if (trimmed(magic) != "ply") return in.error("not a PLY file: it does not begin with \"ply\"");
  bool has_format = false;
  std::size_t bytes = 0;
  while (true) {
    GVX_ASSIGN(const std::string text, in.line());
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
      } else {
        for (std::uint64_t i = 0; i < element.count && !element.properties.empty(); ++i) {
          for (const Property& p : element.properties) GVX_TRY(pass(p));
        }
      }
    }
    return {};
  }

 private:
  Result<double> number(SampleType type) { return in_.number(header_.format, type); }

  Result<std::uint32_t> list_count(const Property& p) {
    GVX_ASSIGN(const double count, number(*p.count_type));
    if (!(count >= 0 && count <= 1e6 && count == std::floor(count))) {
      return in_.error("a list of " + std::to_string(count) + " items");
    }
    return static_cast<std::uint32_t>(count);
  }

  Status pass(const Property& p) {
    std::uint32_t count = 1;
    if (p.count_type) {
      GVX_ASSIGN(count, list_count(p));
    }
    for (std::uint32_t i = 0; i < count; ++i) GVX_TRY(number(p.type));
    return {};
  }

  /// Triangles are handed over as they come, and so must be of vertices that are known.
  Status check_order() {
    int vertices = 0;
    for (const Element& element : header_.elements) {
      if (element.name == "vertex" && ++vertices > 1) return in_.error("has vertices in two places");
      if (element.name == "face" && vertices == 0) return in_.error("has faces before its vertices");
      if (element.name == "vertex" || element.name == "face") all_ += element.count;
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
    if (!triangles_.empty()) GVX_TRY(sink_.add_triangles(triangles_));
    places_.clear();
    colors_.clear();
    triangles_.clear();
    if (progress_) progress_(done_, all_);
    return {};
  }

  Status read_vertices(const Element& element) {
    if (element.count > UINT32_MAX - 1) return in_.error("has more vertices than 32 bits can count");
    // Where each property goes: 0 to 2 a coordinate, 3 to 5 a colour.
    constexpr std::array<const char*, 6> kNames = {"x", "y", "z", "red", "green", "blue"};
    std::vector<int> place;
    std::array<bool, 6> there{};
    for (const Property& p : element.properties) {
      const auto found = std::find(kNames.begin(), kNames.end(), p.name);
      place.push_back(found == kNames.end() || p.count_type ? -1 : static_cast<int>(found - kNames.begin()));
      if (place.back() >= 0) there[static_cast<std::size_t>(place.back())] = true;
    }
    if (!there[0] || !there[1] || !there[2]) return in_.error("its vertices have no x, y and z");
    const bool colored = there[3] && there[4] && there[5];
    for (std::uint64_t i = 0; i < element.count; ++i) {
      std::array<float, 6> values{};
      for (std::size_t k = 0; k < place.size(); ++k) {
        const Property& p = element.properties[k];
        if (place[k] < 0) {
          GVX_TRY(pass(p));
          continue;
        }
        GVX_ASSIGN(const double value, number(p.type));
        const bool bytes = place[k] >= 3 && p.type == SampleType::u8;
        const double scaled = bytes                                        ? value / 255
                              : p.type == SampleType::u16 && place[k] >= 3 ? value / 65535
                                                                           : value;
        values[static_cast<std::size_t>(place[k])] = static_cast<float>(scaled);
      }
      places_.emplace_back(values[0], values[1], values[2]);
      const auto held = [](float c) { return std::isfinite(c) ? std::clamp(c, 0.0f, 1.0f) : 0.0f; };
      if (colored) colors_.emplace_back(held(values[3]), held(values[4]), held(values[5]));
      GVX_TRY(count_one());
    }
    return hand_on();
  }

  Status read_faces(const Element& element) {
    for (std::uint64_t i = 0; i < element.count && !element.properties.empty(); ++i) {
      for (const Property& p : element.properties) {
        if (p.count_type && (p.name == "vertex_indices" || p.name == "vertex_index")) {
          GVX_TRY(read_face(p));
        } else {
          GVX_TRY(pass(p));
        }
      }
      GVX_TRY(count_one());
    }
    return hand_on();
  }

  Status read_face(const Property& p) {
    GVX_ASSIGN(const std::uint32_t count, list_count(p));
    std::uint32_t first = 0, before = 0;
    for (std::uint32_t k = 0; k < count; ++k) {
      GVX_ASSIGN(const double value, number(p.type));
      if (!(value >= 0 && value < static_cast<double>(UINT32_MAX))) {
        return in_.error("a face of a vertex that is not there");
      }
      const auto vertex = static_cast<std::uint32_t>(value);
      if (k == 0) first = vertex;
      if (k >= 2) triangles_.push_back({first, before, vertex});
      before = vertex;
    }
    return {};
  }

  Scanner in_;
  MeshSink& sink_;
  const MeshProgress& progress_;
  Header header_;
  std::uint64_t done_ = 0, all_ = 0;
  std::vector<Vec3f> places_, colors_;
  std::vector<Triangle> triangles_;
};

}  // namespace

Status stream_ply(const std::string& path, MeshSink& sink, const MeshProgress& progress) {
  const Encoding encoding = path.ends_with(".gz") ? Encoding::gzip : Encoding::raw;
  GVX_ASSIGN(auto stream, open_byte_stream(path, encoding, {}, SampleType::u8));
  return PlyReader(std::move(stream), sink, progress).read();
}

}  // namespace gvx::io
