#include "gvx/io/gltf_file.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <utility>

#include "gvx/io/file_source.h"
#include "gvx/io/header_text.h"

namespace gvx::io {
namespace {

using nlohmann::json;

/// Elements that no buffer holds, all 0: more than this are an attack.
constexpr std::uint64_t kMostZeros = 1 << 24;

Result<std::string> read_whole(const std::string& path) {
  GVX_ASSIGN(FileSource source, FileSource::open(path));
  std::string bytes;
  while (true) {
    GVX_ASSIGN(const auto waiting, source.peek());
    if (waiting.empty()) return bytes;
    bytes.append(reinterpret_cast<const char*>(waiting.data()), waiting.size());
    source.consume(waiting.size());
  }
}

template <typename Number>
Number little_endian(const void* bytes) {
  std::array<std::byte, sizeof(Number)> own;
  std::memcpy(own.data(), bytes, sizeof(Number));
  if constexpr (std::endian::native == std::endian::big) std::reverse(own.begin(), own.end());
  return std::bit_cast<Number>(own);
}

/// RFC 4648, section 4; nothing where a byte is none of its alphabet.
std::optional<std::string> from_base64(std::string_view text) {
  std::string bytes;
  std::uint32_t bits = 0;
  int held = 0;
  while (text.ends_with('=')) text.remove_suffix(1);
  for (const char c : text) {
    const int value = c >= 'A' && c <= 'Z'   ? c - 'A'
                      : c >= 'a' && c <= 'z' ? c - 'a' + 26
                      : c >= '0' && c <= '9' ? c - '0' + 52
                      : c == '+'             ? 62
                      : c == '/'             ? 63
                                             : -1;
    if (value < 0) return std::nullopt;
    bits = bits << 6 | static_cast<std::uint32_t>(value);
    held += 6;
    if (held < 8) continue;
    held -= 8;
    bytes.push_back(static_cast<char>(bits >> held & 255));
  }
  return bytes;
}

/// Of a component type; 0 for what is none.
std::uint64_t component_bytes(std::uint64_t type) {
  switch (type) {
    case 5120:
    case 5121:
      return 1;
    case 5122:
    case 5123:
      return 2;
    case 5125:
    case 5126:
      return 4;
    default:
      return 0;
  }
}

double component(const std::byte* bytes, std::uint64_t type, bool normalized) {
  const auto share = [&](auto whole) {
    const auto value = static_cast<double>(whole);
    return normalized
               ? std::max(value / static_cast<double>(std::numeric_limits<decltype(whole)>::max()), -1.0)
               : value;
  };
  switch (type) {
    case 5120:
      return share(little_endian<std::int8_t>(bytes));
    case 5121:
      return share(little_endian<std::uint8_t>(bytes));
    case 5122:
      return share(little_endian<std::int16_t>(bytes));
    case 5123:
      return share(little_endian<std::uint16_t>(bytes));
    case 5125:
      return share(little_endian<std::uint32_t>(bytes));
    default:
      return static_cast<double>(little_endian<float>(bytes));
  }
}

/// Of vectors; 0 for matrices, which no attribute of a surface has, and for what is unknown.
std::size_t components_of(std::string_view type) {
  return type == "SCALAR" ? 1 : type == "VEC2" ? 2 : type == "VEC3" ? 3 : type == "VEC4" ? 4 : 0;
}

std::string text_of(const json& object, const char* field) {
  const auto found = object.find(field);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

/// The JSON and the buffer of a .glb; of a .gltf all of it is JSON.
struct Chunks {
  std::string json, buffer;
};

Result<Chunks> split(const std::string& path, std::string file) {
  if (!file.starts_with("glTF")) return Chunks{std::move(file), {}};
  const auto word = [&](std::size_t at) { return little_endian<std::uint32_t>(file.data() + at); };
  if (file.size() < 20) return file_error(path, "ends early, within the header");
  if (word(4) != 2)
    return file_error(path, "version " + std::to_string(word(4)) + " of the binary format, not 2");
  Chunks chunks;
  std::size_t at = 12;
  for (int i = 0; at + 8 <= file.size(); ++i) {
    const std::size_t bytes = word(at);
    const std::string_view kind(file.data() + at + 4, 4);
    if (bytes > file.size() - at - 8) return file_error(path, "ends early, within a chunk");
    if (i == 0 && kind != "JSON") return file_error(path, "its first chunk is not JSON");
    if (i == 0) chunks.json = file.substr(at + 8, bytes);
    if (i == 1 && kind == std::string_view("BIN\0", 4)) chunks.buffer = file.substr(at + 8, bytes);
    at += 8 + bytes;
  }
  return chunks;
}

}  // namespace

std::string uri_path(std::string_view uri) {
  std::string text;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    const auto digit = [&](std::size_t at) {
      const char c = at < uri.size() ? uri[at] : ' ';
      return c >= '0' && c <= '9'   ? c - '0'
             : c >= 'a' && c <= 'f' ? c - 'a' + 10
             : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                    : -1;
    };
    const int high = digit(i + 1), low = digit(i + 2);
    const bool coded = uri[i] == '%' && high >= 0 && low >= 0;
    text.push_back(coded ? static_cast<char>(16 * high + low) : uri[i]);
    if (coded) i += 2;
  }
  return text;
}

Result<GltfFile> GltfFile::open(const std::string& path) {
  GVX_ASSIGN(std::string file, read_whole(path));
  GVX_ASSIGN(Chunks chunks, split(path, std::move(file)));
  json root = json::parse(chunks.json, nullptr, false);
  if (root.is_discarded() || !root.is_object()) return file_error(path, "not a glTF file: no JSON object");
  GltfFile opened(path, std::move(root));
  const auto asset = opened.root_.find("asset");
  const std::string version =
      asset != opened.root_.end() && asset->is_object() ? text_of(*asset, "version") : std::string();
  if (!version.starts_with("2.")) {
    return opened.error("asset.version: " + io::quoted(version) + ", and only glTF 2.0 is understood");
  }
  GVX_TRY(opened.load_buffers(std::move(chunks.buffer)));
  return opened;
}

Error GltfFile::error(const std::string& message) const {
  return file_error(path_, message);
}

const json& GltfFile::list(const char* name) const {
  static const json nothing = json::array();
  const auto found = root_.find(name);
  return found != root_.end() && found->is_array() ? *found : nothing;
}

Result<const json*> GltfFile::item(const char* list_name, std::uint64_t index) const {
  const json& all = list(list_name);
  if (index >= all.size() || !all[static_cast<std::size_t>(index)].is_object()) {
    return error(std::string(list_name) + ": there is no item " + std::to_string(index));
  }
  return &all[static_cast<std::size_t>(index)];
}

Result<std::optional<std::uint64_t>> GltfFile::index_of(const json& object, const char* field) const {
  const auto found = object.find(field);
  if (found == object.end()) return std::optional<std::uint64_t>();
  // Some write whole numbers with a point.
  const double value = found->is_number() ? found->get<double>() : -1;
  if (!(value >= 0 && value <= 0x1p52 && value == std::floor(value))) {
    return error(std::string(field) + ": expected a whole number, 0 or more");
  }
  return std::optional(static_cast<std::uint64_t>(value));
}

Result<std::optional<std::vector<double>>> GltfFile::numbers(const json& object, const char* field,
                                                             std::size_t count) const {
  const auto found = object.find(field);
  if (found == object.end()) return std::optional<std::vector<double>>();
  std::vector<double> values;
  if (found->is_array()) {
    for (const json& value : *found) {
      if (value.is_number()) values.push_back(value.get<double>());
    }
  }
  if (values.size() != count || found->size() != count) {
    return error(std::string(field) + ": expected " + std::to_string(count) + " numbers");
  }
  return std::optional(std::move(values));
}

bool GltfFile::names_extension(const char* field, std::string_view extension) const {
  const json& all = list(field);
  return std::any_of(all.begin(), all.end(), [&](const json& name) {
    return name.is_string() && name.get_ref<const std::string&>() == extension;
  });
}

Status GltfFile::load_buffers(std::string glb_buffer) {
  const json& all = list("buffers");
  for (std::size_t i = 0; i < all.size(); ++i) {
    GVX_ASSIGN(const json* buffer, item("buffers", i));
    const std::string uri = text_of(*buffer, "uri");
    std::string bytes;
    if (!uri.empty()) {
      GVX_ASSIGN(bytes, load_uri(uri));
    } else if (i == 0) {
      bytes = std::move(glb_buffer);
    }
    GVX_ASSIGN(const auto said, index_of(*buffer, "byteLength"));
    if (said.value_or(0) > bytes.size()) {
      const bool packed = names_extension("extensionsUsed", "EXT_meshopt_compression");
      return error("buffers[" + std::to_string(i) + "]: byteLength: expected " + std::to_string(*said) +
                   " bytes, found " + std::to_string(bytes.size()) +
                   (packed ? "; EXT_meshopt_compression is not supported" : ""));
    }
    buffers_.push_back(std::move(bytes));
  }
  return {};
}

Result<std::string> GltfFile::load_uri(const std::string& uri) const {
  if (lower_case(std::string_view(uri).substr(0, 5)) == "data:") {
    const std::size_t comma = uri.find(',');
    const bool base64 =
        comma != std::string::npos && std::string_view(uri).substr(0, comma).ends_with(";base64");
    auto bytes = base64 ? from_base64(std::string_view(uri).substr(comma + 1)) : std::nullopt;
    if (!bytes) return error("a buffer's data URI is not base64");
    return std::move(*bytes);
  }
  const std::filesystem::path name = uri_path(uri);
  const bool elsewhere = uri.find("://") != std::string::npos || name.is_absolute() ||
                         std::any_of(name.begin(), name.end(), [](const auto& part) { return part == ".."; });
  if (elsewhere) return error("a buffer's URI " + io::quoted(uri) + " leaves the folder of the file");
  return read_whole((std::filesystem::path(path_).parent_path() / name).string());
}

Result<GltfFile::Elements> GltfFile::elements(std::uint64_t view_index, std::uint64_t offset,
                                              std::uint64_t element_bytes, std::uint64_t count) const {
  GVX_ASSIGN(const json* view, item("bufferViews", view_index));
  GVX_ASSIGN(const auto buffer, index_of(*view, "buffer"));
  GVX_ASSIGN(const auto view_offset, index_of(*view, "byteOffset"));
  GVX_ASSIGN(const auto view_bytes, index_of(*view, "byteLength"));
  GVX_ASSIGN(const auto said_stride, index_of(*view, "byteStride"));
  const std::string name = "bufferViews[" + std::to_string(view_index) + "]: ";
  if (!buffer || *buffer >= buffers_.size()) return error(name + "its buffer is not there");
  const std::string& bytes = buffers_[static_cast<std::size_t>(*buffer)];
  const std::uint64_t begin = view_offset.value_or(0), length = view_bytes.value_or(0);
  if (begin > bytes.size() || length > bytes.size() - begin) return error(name + "reaches beyond its buffer");
  const std::uint64_t stride = said_stride.value_or(0) > 0 ? *said_stride : element_bytes;
  if (stride < element_bytes) return error(name + "byteStride is less than an element takes");
  const bool fits = count == 0 || (offset <= length && element_bytes <= length - offset &&
                                   count - 1 <= (length - offset - element_bytes) / stride);
  if (!fits) return error(name + "an accessor reaches beyond it");
  return Elements{
      std::as_bytes(std::span(bytes)).subspan(static_cast<std::size_t>(begin + (count > 0 ? offset : 0))),
      stride};
}

Result<GltfFile::Numbers> GltfFile::accessor(std::uint64_t index) const {
  GVX_ASSIGN(const json* accessor, item("accessors", index));
  const std::string name = "accessors[" + std::to_string(index) + "]: ";
  GVX_ASSIGN(const auto type, index_of(*accessor, "componentType"));
  GVX_ASSIGN(const auto count, index_of(*accessor, "count"));
  GVX_ASSIGN(const auto view, index_of(*accessor, "bufferView"));
  GVX_ASSIGN(const auto offset, index_of(*accessor, "byteOffset"));
  const std::uint64_t bytes = component_bytes(type.value_or(0));
  Numbers numbers;
  numbers.components = components_of(text_of(*accessor, "type"));
  if (bytes == 0) return error(name + "componentType is none of glTF's");
  if (numbers.components == 0) return error(name + "type is none of SCALAR, VEC2, VEC3 and VEC4");
  if (!count) return error(name + "has no count");
  const auto normalized = accessor->find("normalized");
  const bool shares = normalized != accessor->end() && normalized->is_boolean() && normalized->get<bool>();
  if (view) {
    GVX_ASSIGN(const Elements from, elements(*view, offset.value_or(0), numbers.components * bytes, *count));
    numbers.values.reserve(static_cast<std::size_t>(*count) * numbers.components);
    for (std::uint64_t i = 0; i < *count; ++i) {
      for (std::size_t c = 0; c < numbers.components; ++c) {
        numbers.values.push_back(
            component(&from.bytes[static_cast<std::size_t>(i * from.stride + c * bytes)], *type, shares));
      }
    }
  } else {
    if (*count > kMostZeros) return error(name + "has no bufferView and too many elements");
    numbers.values.resize(static_cast<std::size_t>(*count) * numbers.components);
  }
  const auto sparse = accessor->find("sparse");
  if (sparse != accessor->end()) {
    if (!sparse->is_object()) return error(name + "sparse is no object");
    GVX_TRY(overlay_sparse(*sparse, *type, shares, numbers));
  }
  return numbers;
}

Status GltfFile::overlay_sparse(const json& sparse, std::uint64_t type, bool normalized,
                                Numbers& numbers) const {
  GVX_ASSIGN(const auto count, index_of(sparse, "count"));
  const auto indices = sparse.find("indices"), values = sparse.find("values");
  if (!count || indices == sparse.end() || !indices->is_object() || values == sparse.end() ||
      !values->is_object()) {
    return error("a sparse accessor without count, indices or values");
  }
  GVX_ASSIGN(const auto index_type, index_of(*indices, "componentType"));
  GVX_ASSIGN(const auto index_view, index_of(*indices, "bufferView"));
  GVX_ASSIGN(const auto index_offset, index_of(*indices, "byteOffset"));
  GVX_ASSIGN(const auto value_view, index_of(*values, "bufferView"));
  GVX_ASSIGN(const auto value_offset, index_of(*values, "byteOffset"));
  const std::uint64_t index_bytes = component_bytes(index_type.value_or(0)), bytes = component_bytes(type);
  if (index_bytes == 0 || index_type == 5126 || !index_view || !value_view) {
    return error("a sparse accessor whose indices or values have no bufferView");
  }
  GVX_ASSIGN(const Elements where, elements(*index_view, index_offset.value_or(0), index_bytes, *count));
  GVX_ASSIGN(const Elements what,
             elements(*value_view, value_offset.value_or(0), numbers.components * bytes, *count));
  for (std::uint64_t i = 0; i < *count; ++i) {
    const double at = component(&where.bytes[static_cast<std::size_t>(i * where.stride)], *index_type, false);
    if (!(at >= 0 && at < static_cast<double>(numbers.count()))) {
      return error("a sparse accessor with an index beyond its count");
    }
    for (std::size_t c = 0; c < numbers.components; ++c) {
      numbers.values[static_cast<std::size_t>(at) * numbers.components + c] =
          component(&what.bytes[static_cast<std::size_t>(i * what.stride + c * bytes)], type, normalized);
    }
  }
  return {};
}

}  // namespace gvx::io
