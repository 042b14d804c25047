#include "gvx/io/mesh_gltf.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>
#include <vector>

#include "gvx/core/affine.h"
#include "gvx/io/gltf_file.h"
#include "gvx/io/srgb.h"

namespace gvx::io {
namespace {

using nlohmann::json;

constexpr std::size_t kMany = 1 << 14;

/// Can a file that requires the extension be read without knowing it? Those of materials, textures and lights
/// change no shape.
bool changes_no_shape(std::string_view extension) {
  return extension == "KHR_mesh_quantization" || extension == "KHR_lights_punctual" ||
         extension == "KHR_animation_pointer" || extension == "KHR_xmp_json_ld" ||
         extension.starts_with("KHR_materials_") || extension.starts_with("KHR_texture_") ||
         extension.starts_with("EXT_texture_") || extension.starts_with("MSFT_texture_");
}

const json* object_in(const json& object, const char* field) {
  const auto found = object.find(field);
  return found != object.end() && found->is_object() ? &*found : nullptr;
}

const json& list_in(const json& object, const char* field) {
  static const json nothing = json::array();
  const auto found = object.find(field);
  return found != object.end() && found->is_array() ? *found : nothing;
}

/// Rotation by a quaternion x, y, z, w, times scales.
Affine3 turned(const std::vector<double>& q, const std::vector<double>& s) {
  const double size = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  const double n = size > 0 ? 1 / size : 0;
  const double x = n * q[0], y = n * q[1], z = n * q[2], w = size > 0 ? n * q[3] : 1;
  return {{s[0] * Vec3d(1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)),
           s[1] * Vec3d(2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)),
           s[2] * Vec3d(2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y))},
          {}};
}

class GltfReader {
 public:
  GltfReader(const GltfFile& file, MeshSink& sink, const MeshProgress& progress)
      : file_(file), sink_(sink), progress_(progress) {}

  Status read() {
    GVX_TRY(check_extensions());
    for (const auto& [field, what] :
         {std::pair{"textures", "textures"}, {"animations", "animations"}, {"skins", "skins"}}) {
      if (!file_.list(field).empty()) sink_.pass_over(what);
    }
    GVX_ASSIGN(const std::vector<std::uint64_t> roots, roots_of_scene());
    visited_.resize(file_.list("nodes").size());
    struct Waiting {
      std::uint64_t node;
      Affine3 parent;
    };
    std::vector<Waiting> waiting;
    for (const std::uint64_t root : roots) waiting.push_back({root, {}});
    std::reverse(waiting.begin(), waiting.end());
    std::uint64_t done = 0;
    while (!waiting.empty()) {
      const Waiting next = waiting.back();
      waiting.pop_back();
      GVX_ASSIGN(const json* node, file_.item("nodes", next.node));
      if (visited_[static_cast<std::size_t>(next.node)]) {
        return file_.error("nodes[" + std::to_string(next.node) +
                           "]: has two parents, or is its own ancestor");
      }
      visited_[static_cast<std::size_t>(next.node)] = true;
      GVX_ASSIGN(const Affine3 own, placement(*node));
      const Affine3 placed = next.parent * own;
      GVX_TRY(take_node(*node, placed));
      GVX_ASSIGN(const std::vector<std::uint64_t> children, indices_in(*node, "children"));
      for (auto child = children.rbegin(); child != children.rend(); ++child)
        waiting.push_back({*child, placed});
      if (progress_) progress_(++done, visited_.size());
    }
    return {};
  }

 private:
  Status check_extensions() {
    for (const json& name : file_.list("extensionsRequired")) {
      if (!name.is_string()) return file_.error("extensionsRequired: expected names");
      const auto& extension = name.get_ref<const std::string&>();
      if (!changes_no_shape(extension)) {
        return file_.error("requires the extension " + extension.substr(0, 60) + ", which is not supported");
      }
    }
    if (file_.names_extension("extensionsUsed", "EXT_mesh_gpu_instancing")) {
      sink_.pass_over("instances (EXT_mesh_gpu_instancing)");
    }
    return {};
  }

  Result<std::vector<std::uint64_t>> indices_in(const json& object, const char* field) const {
    std::vector<std::uint64_t> indices;
    for (const json& index : list_in(object, field)) {
      if (!index.is_number_unsigned()) return file_.error(std::string(field) + ": expected indices");
      indices.push_back(index.get<std::uint64_t>());
    }
    return indices;
  }

  /// Of the scene that the file names, or the first; where there is none, all that are no node's child.
  Result<std::vector<std::uint64_t>> roots_of_scene() const {
    GVX_ASSIGN(const auto named, file_.index_of(file_.root(), "scene"));
    if (named || !file_.list("scenes").empty()) {
      GVX_ASSIGN(const json* scene, file_.item("scenes", named.value_or(0)));
      return indices_in(*scene, "nodes");
    }
    const std::size_t count = file_.list("nodes").size();
    std::vector<bool> child(count);
    for (std::size_t i = 0; i < count; ++i) {
      GVX_ASSIGN(const json* node, file_.item("nodes", i));
      GVX_ASSIGN(const std::vector<std::uint64_t> children, indices_in(*node, "children"));
      for (const std::uint64_t c : children) {
        if (c < count) child[static_cast<std::size_t>(c)] = true;
      }
    }
    std::vector<std::uint64_t> roots;
    for (std::size_t i = 0; i < count; ++i) {
      if (!child[i]) roots.push_back(i);
    }
    return roots;
  }

  Result<Affine3> placement(const json& node) const {
    GVX_ASSIGN(const auto m, file_.numbers(node, "matrix", 16));
    if (m) {
      const std::vector<double>& v = *m;
      return Affine3{{{v[0], v[1], v[2]}, {v[4], v[5], v[6]}, {v[8], v[9], v[10]}}, {v[12], v[13], v[14]}};
    }
    GVX_ASSIGN(const auto translation, file_.numbers(node, "translation", 3));
    GVX_ASSIGN(const auto rotation, file_.numbers(node, "rotation", 4));
    GVX_ASSIGN(const auto scale, file_.numbers(node, "scale", 3));
    Affine3 placed = turned(rotation.value_or(std::vector<double>{0, 0, 0, 1}),
                            scale.value_or(std::vector<double>(3, 1.0)));
    if (translation) placed.origin = {(*translation)[0], (*translation)[1], (*translation)[2]};
    return placed;
  }

  Status take_node(const json& node, const Affine3& placed) {
    GVX_ASSIGN(const auto index, file_.index_of(node, "mesh"));
    if (!index) return {};
    GVX_ASSIGN(const json* mesh, file_.item("meshes", *index));
    for (const json& primitive : list_in(*mesh, "primitives")) {
      if (!primitive.is_object())
        return file_.error("meshes[" + std::to_string(*index) + "]: a primitive is no object");
      GVX_TRY(take_primitive(primitive, placed));
    }
    return {};
  }

  Status take_primitive(const json& primitive, const Affine3& placed) {
    GVX_ASSIGN(const auto said_mode, file_.index_of(primitive, "mode"));
    const std::uint64_t mode = said_mode.value_or(4);
    if (mode > 6)
      return file_.error("a primitive of mode " + std::to_string(mode) + ", which glTF does not have");
    if (mode < 4) {
      sink_.pass_over(mode == 0 ? "points" : "lines");
      return {};
    }
    const json* attributes = object_in(primitive, "attributes");
    if (attributes == nullptr) return file_.error("a primitive without attributes");
    if (attributes->contains("TEXCOORD_0")) sink_.pass_over("texture coordinates");
    if (!list_in(primitive, "targets").empty()) sink_.pass_over("morph targets");
    GVX_TRY(check_packing(primitive));

    GVX_ASSIGN(const auto position, file_.index_of(*attributes, "POSITION"));
    if (!position) return {};
    GVX_ASSIGN(const GltfFile::Numbers places, file_.accessor(*position));
    if (places.components != 3) return file_.error("POSITION: expected three numbers for each vertex");
    if (places.count() + first_ >= UINT32_MAX) return file_.error("has more vertices than 32 bits can count");
    GVX_ASSIGN(const std::optional<std::vector<double>> factor, base_color(primitive));
    GVX_ASSIGN(const auto color, file_.index_of(*attributes, "COLOR_0"));
    GltfFile::Numbers colors;
    if (color) {
      GVX_ASSIGN(colors, file_.accessor(*color));
      if (colors.components < 3 || colors.count() != places.count()) {
        return file_.error("COLOR_0: expected three or four numbers for each vertex");
      }
    }
    GVX_TRY(add_vertices(places, color ? &colors : nullptr, factor, placed));
    GVX_ASSIGN(const auto indices, file_.index_of(primitive, "indices"));
    GltfFile::Numbers order;
    if (indices) {
      GVX_ASSIGN(order, file_.accessor(*indices));
      if (order.components != 1) return file_.error("indices: expected one number each");
    }
    GVX_TRY(add_triangles(mode, indices ? &order : nullptr, places.count(), determinant(placed) < 0));
    first_ += static_cast<std::uint32_t>(places.count());
    return {};
  }

  /// Geometry that only an extension can unpack.
  Status check_packing(const json& primitive) const {
    const json* extensions = object_in(primitive, "extensions");
    if (extensions == nullptr || !extensions->contains("KHR_draco_mesh_compression")) return {};
    const json& attributes = *object_in(primitive, "attributes");
    GVX_ASSIGN(const auto position, file_.index_of(attributes, "POSITION"));
    if (!position) return {};
    GVX_ASSIGN(const json* accessor, file_.item("accessors", *position));
    if (accessor->contains("bufferView")) return {};
    return file_.error("is packed with the extension KHR_draco_mesh_compression, which is not supported");
  }

  /// Linear; none where nothing is said of it, or a texture would say it.
  Result<std::optional<std::vector<double>>> base_color(const json& primitive) {
    GVX_ASSIGN(const auto index, file_.index_of(primitive, "material"));
    if (!index) return std::optional<std::vector<double>>();
    GVX_ASSIGN(const json* material, file_.item("materials", *index));
    const auto alpha = material->find("alphaMode");
    if (alpha != material->end() && *alpha != "OPAQUE") sink_.pass_over("transparency of materials");
    const json* extensions = object_in(*material, "extensions");
    const json* specular =
        extensions != nullptr ? object_in(*extensions, "KHR_materials_pbrSpecularGlossiness") : nullptr;
    const json* base = specular != nullptr ? specular : object_in(*material, "pbrMetallicRoughness");
    if (base == nullptr) return std::optional(std::vector<double>(4, 1.0));
    GVX_ASSIGN(auto factor,
               file_.numbers(*base, specular != nullptr ? "diffuseFactor" : "baseColorFactor", 4));
    if (factor) return factor;
    if (base->contains("baseColorTexture") || base->contains("diffuseTexture")) return factor;
    return std::optional(std::vector<double>(4, 1.0));
  }

  Status add_vertices(const GltfFile::Numbers& places, const GltfFile::Numbers* colors,
                      const std::optional<std::vector<double>>& factor, const Affine3& placed) {
    std::vector<Vec3d> these;
    std::vector<Vec3f> shown;
    for (std::size_t v = 0; v < places.count(); ++v) {
      const double* p = &places.values[3 * v];
      these.push_back(placed.point({p[0], p[1], p[2]}));
      if (colors != nullptr || factor) {
        Vec3f& color = shown.emplace_back();
        for (std::size_t c = 0; c < 3; ++c) {
          const double linear = (colors != nullptr ? colors->values[colors->components * v + c] : 1.0) *
                                (factor ? (*factor)[c] : 1.0);
          color[static_cast<int>(c)] =
              std::isfinite(linear) ? static_cast<float>(to_display(std::clamp(linear, 0.0, 1.0))) : 0;
        }
      }
      if (these.size() == kMany || v + 1 == places.count()) {
        GVX_TRY(sink_.add_vertices(these, shown));
        these.clear();
        shown.clear();
      }
    }
    return {};
  }

  /// Lists, strips and fans, of vertices in `order` or one after the other; turned round where a node
  /// mirrors.
  Status add_triangles(std::uint64_t mode, const GltfFile::Numbers* order, std::size_t vertices,
                       bool mirrored) {
    const std::size_t count = order != nullptr ? order->count() : vertices;
    const auto vertex = [&](std::size_t i) {
      const double index = order != nullptr ? order->values[i] : static_cast<double>(i);
      return index >= 0 && index < static_cast<double>(vertices) ? first_ + static_cast<std::uint32_t>(index)
                                                                 : UINT32_MAX;
    };
    std::vector<Triangle> triangles;
    for (std::size_t i = 2; i < count; i += mode == 4 ? 3 : 1) {
      Triangle t = {vertex(mode == 6 ? 0 : i - 2), vertex(i - 1), vertex(i)};
      // Every other triangle of a strip goes the other way round.
      if ((mode == 5 && i % 2 != 0) != mirrored) std::swap(t[0], t[1]);
      triangles.push_back(t);
      if (triangles.size() == kMany) {
        GVX_TRY(sink_.add_triangles(triangles));
        triangles.clear();
      }
    }
    return triangles.empty() ? Status() : sink_.add_triangles(triangles);
  }

  const GltfFile& file_;
  MeshSink& sink_;
  const MeshProgress& progress_;
  std::vector<bool> visited_;  // of the nodes
  std::uint32_t first_ = 0;    // vertex of the next primitive
};

}  // namespace

Status stream_gltf(const std::string& path, MeshSink& sink, const MeshProgress& progress) {
  GVX_ASSIGN(const GltfFile file, GltfFile::open(path));
  return GltfReader(file, sink, progress).read();
}

}  // namespace gvx::io
