/// \file
/// GltfFile: the JSON and the buffers of a glTF 2.0 file (.gltf or .glb), and the numbers of its accessors.
/// What the file says is checked before it is used.
///
///     accessor: count, type, componentType
///       -> bufferView: offset, stride
///         -> buffer: the .glb's own, a data URI, or a file beside it
#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "gvx/core/result.h"

namespace gvx::io {

/// A URI's path: "%20" is a space.
std::string uri_path(std::string_view uri);

/// The file's JSON, and its buffers in memory.
class GltfFile {
 public:
  /// Reads it with all buffers. An error where it is no glTF 2.0 file.
  static Result<GltfFile> open(const std::string& path);

  /// "FILE: MESSAGE".
  Error error(const std::string& message) const;

  /// The whole JSON, an object.
  const nlohmann::json& root() const { return root_; }

  /// An array of the root, such as "meshes"; empty where there is none.
  const nlohmann::json& list(const char* name) const;

  /// The item of it with this index; an error where there is none, or it is no object.
  Result<const nlohmann::json*> item(const char* list_name, std::uint64_t index) const;

  /// The whole number of a field, 0 or more; nothing where there is no such field. An error for any other
  /// value.
  Result<std::optional<std::uint64_t>> index_of(const nlohmann::json& object, const char* field) const;

  /// The `count` numbers of a field; nothing where there is no such field. An error for any other value.
  Result<std::optional<std::vector<double>>> numbers(const nlohmann::json& object, const char* field,
                                                     std::size_t count) const;

  /// Numbers that belong together, such as places.
  struct Numbers {
    std::size_t components = 0;  ///< of each element
    std::vector<double> values;  ///< of all elements, one behind the other; whole ones as their type says

    std::size_t count() const { return components > 0 ? values.size() / components : 0; }
  };

  /// Those of an accessor, sparse ones included. Whole numbers become shares of 1, or -1 to 1, where the
  /// accessor says that they are normalized.
  Result<Numbers> accessor(std::uint64_t index) const;

  /// Does the field of the root ("extensionsUsed", "extensionsRequired") name it?
  bool names_extension(const char* field, std::string_view extension) const;

 private:
  GltfFile(std::string path, nlohmann::json root) : path_(std::move(path)), root_(std::move(root)) {}

  /// Elements that stand in a buffer view.
  struct Elements {
    std::span<const std::byte> bytes;  ///< from the first one on
    std::uint64_t stride = 0;
  };

  Status load_buffers(std::string glb_buffer);
  Result<std::string> load_uri(const std::string& uri) const;
  /// An error where they do not fit the view.
  Result<Elements> elements(std::uint64_t view, std::uint64_t offset, std::uint64_t element_bytes,
                            std::uint64_t count) const;
  Status overlay_sparse(const nlohmann::json& sparse, std::uint64_t type, bool normalized,
                        Numbers& numbers) const;

  std::string path_;
  nlohmann::json root_;
  std::vector<std::string> buffers_;
};

}  // namespace gvx::io
