#include "gvx/io/mesh_obj.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "gvx/io/byte_stream.h"
#include "gvx/io/header_text.h"
#include "gvx/io/text_scanner.h"

namespace gvx::io {
namespace {

constexpr std::size_t kLongestLine = 1 << 26, kMany = 1 << 14;
constexpr Vec3f kPlain{0.8f, 0.8f, 0.8f};

float held(double share) {
  return std::isfinite(share) ? static_cast<float>(std::clamp(share, 0.0, 1.0)) : 0.0f;
}

Result<TextScanner> open_text(const std::string& path) {
  GVX_ASSIGN(auto stream, open_byte_stream(path, Encoding::raw, {}, SampleType::u8));
  return TextScanner(std::move(stream));
}

/// The next line without its comment; those that end in a backslash with the ones behind them.
Result<bool> next_line(TextScanner& in, std::string& text) {
  GVX_ASSIGN(bool more, in.line(text, kLongestLine));
  const bool any = more;
  std::string rest;
  while (more && text.ends_with('\\')) {
    text.pop_back();
    GVX_ASSIGN(more, in.line(rest, kLongestLine));
    if (text.size() + rest.size() > kLongestLine) return in.error("a line is too long");
    text += ' ' + rest;
  }
  // Within a word it is none: some write 1.#INF.
  std::size_t comment = text.find('#');
  while (comment != std::string::npos && comment > 0 && text[comment - 1] != ' ' &&
         text[comment - 1] != '\t') {
    comment = text.find('#', comment + 1);
  }
  text.resize(std::min(comment, text.size()));
  return any;
}

/// As parse_number(), and no number where it is what some libraries write for none, such as 1.#IND.
std::optional<double> parse_place(std::string_view text) {
  const auto number = parse_number(text);
  if (number || text.find(".#") == std::string_view::npos) return number;
  return std::numeric_limits<double>::quiet_NaN();
}

/// What stands behind a line's first word, such as a name with blanks in it.
std::string behind_first_word(std::string_view text) {
  const std::string_view line = trimmed(text);
  return std::string(trimmed(line.substr(std::min(line.find_first_of(" \t"), line.size()))));
}

/// Materials' diffuse colours by their names.
using Materials = std::map<std::string, std::optional<Vec3f>, std::less<>>;

Status read_materials(const std::string& path, MeshSink& sink, Materials& materials) {
  GVX_ASSIGN(TextScanner in, open_text(path));
  std::string text;
  std::optional<Vec3f>* color = nullptr;
  while (true) {
    GVX_ASSIGN(const bool more, next_line(in, text));
    if (!more) return {};
    const std::vector<std::string_view> line = words(text);
    if (line.empty()) continue;
    const std::string key = lower_case(line[0]);
    if (key == "newmtl") color = &materials[behind_first_word(text)];
    if (key == "kd" && color != nullptr && line.size() >= 2) {
      // One number stands for three.
      const auto red = parse_number(line[1]), green = line.size() >= 4 ? parse_number(line[2]) : red,
                 blue = line.size() >= 4 ? parse_number(line[3]) : red;
      if (red && green && blue) *color = Vec3f(held(*red), held(*green), held(*blue));
    }
    if (key.starts_with("map_") || key == "bump" || key == "disp" || key == "decal")
      sink.pass_over("textures");
    if (key == "d" && line.size() == 2 && parse_number(line[1]).value_or(1) < 1) {
      sink.pass_over("transparency of materials");
    }
  }
}

class ObjReader {
 public:
  ObjReader(const std::string& path, MeshSink& sink, const MeshProgress& progress)
      : path_(path), sink_(sink), progress_(progress) {}

  Status read() {
    std::error_code error;
    bytes_ = std::filesystem::file_size(path_, error);
    GVX_TRY(each_line([&](TextScanner& in, const auto& line) { return take_vertex(in, line); }));
    GVX_TRY(hand_on_vertices());
    vertices_ = std::exchange(so_far_, 0);
    GVX_TRY(each_line([&](TextScanner& in, const auto& line) { return take_face(in, line); }));
    return hand_on_triangles();
  }

 private:
  template <typename Function>
  Status each_line(const Function& function) {
    GVX_ASSIGN(TextScanner in, open_text(path_));
    std::uint64_t lines = 0;
    while (true) {
      GVX_ASSIGN(const bool more, next_line(in, text_));
      if (!more) break;
      const std::vector<std::string_view> line = words(text_);
      if (!line.empty()) GVX_TRY(function(in, line));
      if (progress_ && ++lines % (1 << 14) == 0) progress_(passed_ + in.bytes_consumed(), 2 * bytes_);
    }
    passed_ += bytes_;
    return {};
  }

  Status take_vertex(TextScanner& in, const std::vector<std::string_view>& line) {
    if (line[0] != "v") return {};
    // x y z, perhaps w, perhaps red green blue.
    std::array<double, 7> numbers{};
    const std::size_t count = std::min<std::size_t>(line.size() - 1, 7);
    if (count < 3) return in.error("a vertex of fewer than three numbers: " + io::quoted(text_));
    for (std::size_t i = 0; i < count; ++i) {
      const auto number = parse_place(line[i + 1]);
      if (!number && i < 3)
        return in.error("a vertex with something that is not a number: " + io::quoted(text_));
      numbers[i] = number.value_or(0);
    }
    if (++so_far_ >= UINT32_MAX) return in.error("has more vertices than 32 bits can count");
    places_.emplace_back(numbers[0], numbers[1], numbers[2]);
    if (count >= 6) {
      colors_.resize(places_.size() - 1, kPlain);
      const std::size_t red = count == 7 ? 4 : 3;
      colors_.emplace_back(held(numbers[red]), held(numbers[red + 1]), held(numbers[red + 2]));
      has_vertex_colors_ = true;
    } else if (!colors_.empty()) {
      colors_.push_back(kPlain);
    }
    return places_.size() < kMany ? Status() : hand_on_vertices();
  }

  Status hand_on_vertices() {
    if (!places_.empty()) GVX_TRY(sink_.add_vertices(places_, colors_));
    places_.clear();
    colors_.clear();
    return {};
  }

  Status take_face(TextScanner& in, const std::vector<std::string_view>& line) {
    const std::string_view key = line[0];
    if (key == "v") ++so_far_;
    if (key == "l") sink_.pass_over("lines");
    if (key == "p") sink_.pass_over("points");
    if (key == "vt") sink_.pass_over("texture coordinates");
    if (key == "curv" || key == "curv2" || key == "surf") sink_.pass_over("curves and curved surfaces");
    if (key == "mtllib") return take_materials(behind_first_word(text_));
    if (key == "usemtl") {
      const auto found = materials_.find(behind_first_word(text_));
      color_ = found == materials_.end() ? std::nullopt : found->second;
      if (color_ && has_vertex_colors_) sink_.pass_over("colours of materials (those of vertices are shown)");
    }
    return key == "f" || key == "fo" ? add_face(in, line) : Status();
  }

  Status take_materials(const std::string& names) {
    // One name, which may have blanks in it, or several.
    std::error_code error;
    std::vector<std::string> files = {names};
    if (!std::filesystem::is_regular_file(beside(path_, names), error)) {
      files.clear();
      for (const std::string_view name : words(names)) files.emplace_back(name);
    }
    for (const std::string& file : files) {
      if (!read_materials(beside(path_, file), sink_, materials_).ok()) {
        sink_.pass_over("materials of " + io::quoted(file) + ", which cannot be read");
      }
    }
    return {};
  }

  Status add_face(TextScanner& in, const std::vector<std::string_view>& line) {
    corners_.clear();
    for (std::size_t i = 1; i < line.size(); ++i) {
      // What is behind a slash says texture coordinates and normals.
      const auto index = parse_integer(line[i].substr(0, line[i].find('/')));
      if (!index) return in.error("a face with something that is not an index: " + io::quoted(text_));
      // From 1, or backwards from the last that came.
      const std::int64_t vertex = *index > 0 ? *index - 1 : static_cast<std::int64_t>(so_far_) + *index;
      const bool there = *index != 0 && vertex >= 0 && vertex < static_cast<std::int64_t>(vertices_);
      if (!there) return in.error("a face of a vertex that is not there: " + io::quoted(text_));
      corners_.push_back(static_cast<std::uint32_t>(vertex));
    }
    const bool colored = !has_vertex_colors_ && (color_ || !triangle_colors_.empty());
    if (colored) triangle_colors_.resize(triangles_.size(), kPlain);
    GVX_TRY(cut_polygon(sink_, corners_, triangles_));
    if (colored) triangle_colors_.resize(triangles_.size(), color_.value_or(kPlain));
    return triangles_.size() < kMany ? Status() : hand_on_triangles();
  }

  Status hand_on_triangles() {
    if (!triangles_.empty()) GVX_TRY(sink_.add_triangles(triangles_, triangle_colors_));
    triangles_.clear();
    triangle_colors_.clear();
    return {};
  }

  const std::string& path_;
  MeshSink& sink_;
  const MeshProgress& progress_;
  std::string text_;
  std::uint64_t bytes_ = 0, passed_ = 0, vertices_ = 0;
  std::uint64_t so_far_ = 0;  // vertices that came before the line
  bool has_vertex_colors_ = false;
  std::vector<Vec3d> places_;
  std::vector<Vec3f> colors_, triangle_colors_;
  std::vector<Triangle> triangles_;
  std::vector<std::uint32_t> corners_;
  Materials materials_;
  std::optional<Vec3f> color_;  // of the faces that come
};

}  // namespace

Status stream_obj(const std::string& path, MeshSink& sink, const MeshProgress& progress) {
  return ObjReader(path, sink, progress).read();
}

}  // namespace gvx::io
