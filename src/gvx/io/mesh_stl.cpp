#include "gvx/io/mesh_stl.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <filesystem>
#include <optional>
#include <string_view>
#include <vector>

#include "gvx/io/byte_stream.h"
#include "gvx/io/header_text.h"
#include "gvx/io/text_scanner.h"

namespace gvx::io {
namespace {

constexpr std::uint64_t kHeaderBytes = 84, kFacetBytes = 50;
constexpr std::size_t kLongestLine = 1 << 20;

/// Hands over triangles that have vertices of their own.
class Facets {
 public:
  Facets(TextScanner& in, MeshSink& sink) : in_(in), sink_(sink) {}

  Status push(std::span<const Vec3d> corners, std::optional<Vec3f> color = {}) {
    if (vertices_ + corners.size() >= UINT32_MAX)
      return in_.error("has more vertices than 32 bits can count");
    places_.insert(places_.end(), corners.begin(), corners.end());
    std::vector<std::uint32_t> ring;
    for (std::size_t k = 0; k < corners.size(); ++k) ring.push_back(vertices_++);
    if (color || !colors_.empty()) colors_.resize(triangles_.size(), kPlain);
    if (ring.size() != 3) GVX_TRY(hand_on_vertices());
    GVX_TRY(cut_polygon(sink_, ring, triangles_));
    if (color || !colors_.empty()) colors_.resize(triangles_.size(), color.value_or(kPlain));
    return triangles_.size() < (1 << 14) ? Status() : hand_on();
  }

  Status hand_on() {
    GVX_TRY(hand_on_vertices());
    if (!triangles_.empty()) GVX_TRY(sink_.add_triangles(triangles_, colors_));
    triangles_.clear();
    colors_.clear();
    return {};
  }

 private:
  static constexpr Vec3f kPlain{0.8f, 0.8f, 0.8f};

  Status hand_on_vertices() {
    if (!places_.empty()) GVX_TRY(sink_.add_vertices(places_, {}));
    places_.clear();
    return {};
  }

  TextScanner& in_;
  MeshSink& sink_;
  std::uint32_t vertices_ = 0;
  std::vector<Vec3d> places_;
  std::vector<Triangle> triangles_;
  std::vector<Vec3f> colors_;
};

template <typename Number>
Number little_endian(const std::byte* bytes) {
  std::array<std::byte, sizeof(Number)> own;
  std::memcpy(own.data(), bytes, sizeof(Number));
  if constexpr (std::endian::native == std::endian::big) std::reverse(own.begin(), own.end());
  return std::bit_cast<Number>(own);
}

/// Colours of facets, five bits a channel. VisCAM has blue in the lowest bits and sets the highest bit of
/// facets that have a colour; Magics has red there, clears that bit, and says "COLOR=" with one for the rest
/// in the header.
class FacetColors {
 public:
  explicit FacetColors(std::string_view header) {
    const std::size_t at = header.substr(0, 80).find("COLOR=");
    if (at == std::string_view::npos || at + 9 > 80) return;
    const auto share = [&](std::size_t i) {
      return static_cast<float>(static_cast<unsigned char>(header[i])) / 255;
    };
    rest_ = Vec3f(share(at + 6), share(at + 7), share(at + 8));
  }

  std::optional<Vec3f> of(std::uint16_t bits) const {
    const bool highest = bits >> 15 != 0;
    if (rest_ ? highest : !highest) return rest_;
    const Vec3f low_first(share(bits), share(bits >> 5), share(bits >> 10));
    return rest_ ? low_first : Vec3f(low_first.z, low_first.y, low_first.x);
  }

 private:
  static float share(int bits) { return static_cast<float>(bits & 31) / 31; }

  std::optional<Vec3f> rest_;  // of Magics' facets without one
};

Status stream_binary(TextScanner& in, std::uint64_t file_bytes, MeshSink& sink,
                     const MeshProgress& progress) {
  std::string header(kHeaderBytes, '\0');
  GVX_TRY(in.read(std::as_writable_bytes(std::span(header))));
  const std::uint64_t count =
      little_endian<std::uint32_t>(reinterpret_cast<const std::byte*>(header.data()) + 80);
  const std::uint64_t needed = kHeaderBytes + count * kFacetBytes;
  if (needed > file_bytes) {
    return in.error("ends early: its " + std::to_string(count) + " facets would take " +
                    std::to_string(needed) + " bytes, and there are " + std::to_string(file_bytes));
  }
  const FacetColors colors(header);
  Facets facets(in, sink);
  std::array<std::byte, kFacetBytes> bytes;
  for (std::uint64_t i = 0; i < count; ++i) {
    GVX_TRY(in.read(bytes));
    std::array<Vec3d, 3> corners;
    for (int k = 0; k < 9; ++k) {
      corners[static_cast<std::size_t>(k / 3)][k % 3] =
          double(little_endian<float>(&bytes[static_cast<std::size_t>(12 + 4 * k)]));
    }
    GVX_TRY(facets.push(corners, colors.of(little_endian<std::uint16_t>(&bytes[48]))));
    if (progress && i % (1 << 14) == 0) progress(i, count);
  }
  return facets.hand_on();
}

Status stream_text(TextScanner& in, std::uint64_t file_bytes, MeshSink& sink, const MeshProgress& progress) {
  Facets facets(in, sink);
  std::vector<Vec3d> corners;
  std::string text;
  std::uint64_t lines = 0;
  while (true) {
    GVX_ASSIGN(const bool more, in.line(text, kLongestLine));
    if (!more) break;
    if (progress && ++lines % (1 << 16) == 0) progress(in.bytes_consumed(), file_bytes);
    const std::vector<std::string_view> line = words(text);
    for (std::size_t i = 0; i < line.size(); ++i) {
      const std::string word = lower_case(line[i]);
      // Behind them stands a name, of any words.
      if (word == "solid" || word == "endsolid") break;
      if (word == "endloop") {
        if (corners.size() < 3) return in.error("a facet of " + std::to_string(corners.size()) + " vertices");
        GVX_TRY(facets.push(corners));
        corners.clear();
      }
      if (word != "vertex") continue;
      Vec3d place;
      for (int axis = 0; axis < 3; ++axis) {
        const auto number = ++i < line.size() ? parse_number(line[i]) : std::nullopt;
        if (!number) return in.error("a vertex is not followed by three numbers: " + io::quoted(text));
        place[axis] = *number;
      }
      corners.push_back(place);
    }
  }
  if (!corners.empty()) return in.error("ends early, within a facet");
  return facets.hand_on();
}

/// Many binary files begin with "solid", too.
Result<bool> is_text(const std::string& path, std::uint64_t file_bytes) {
  GVX_ASSIGN(const std::string start, read_file_start(path));
  if (!lower_case(trimmed(std::string_view(start).substr(0, 80))).starts_with("solid")) return false;
  if (start.size() < kHeaderBytes) return true;
  const std::uint64_t count =
      little_endian<std::uint32_t>(reinterpret_cast<const std::byte*>(start.data()) + 80);
  const bool has_zeros = std::string_view(start).substr(0, 512).find('\0') != std::string_view::npos;
  return kHeaderBytes + count * kFacetBytes != file_bytes && !has_zeros;
}

}  // namespace

Status stream_stl(const std::string& path, MeshSink& sink, const MeshProgress& progress) {
  std::error_code error;
  const std::uint64_t file_bytes = std::filesystem::file_size(path, error);
  if (error) return file_error(path, "cannot tell its size: " + error.message());
  GVX_ASSIGN(const bool text, is_text(path, file_bytes));
  GVX_ASSIGN(auto stream, open_byte_stream(path, Encoding::raw, {}, SampleType::u8));
  TextScanner in(std::move(stream));
  if (text) return stream_text(in, file_bytes, sink, progress);
  if (file_bytes < kHeaderBytes) {
    return in.error(
        "not an STL file: neither text that begins with \"solid\" nor a binary header of 84 bytes");
  }
  return stream_binary(in, file_bytes, sink, progress);
}

}  // namespace gvx::io
