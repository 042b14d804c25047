#include "gvx/io/mesh.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "gvx/io/header_text.h"
#include "gvx/io/mesh_ply.h"

#if defined(GVX_WITH_ASSIMP)
#include <assimp/Importer.hpp>

#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#endif

namespace gvx::io {
namespace {

constexpr std::array<const char*, 6> kEndings = {".ply", ".ply.gz", ".obj", ".stl", ".gltf", ".glb"};

bool ends_as(const std::string& path, const char* ending) {
  return lower_case(path).ends_with(ending);
}

bool is_ply(const std::string& path) {
  return ends_as(path, ".ply") || ends_as(path, ".ply.gz");
}

/// Keeps what covers anything, and counts what does not.
class MeshCollector final : public MeshSink {
 public:
  Status add_vertices(std::span<const Vec3f> places, std::span<const Vec3f> colors) override {
    mesh_.vertices.insert(mesh_.vertices.end(), places.begin(), places.end());
    mesh_.colors.insert(mesh_.colors.end(), colors.begin(), colors.end());
    return {};
  }

  Status add_triangles(std::span<const Triangle> triangles) override {
    for (const Triangle& t : triangles) {
      const bool there =
          std::all_of(t.begin(), t.end(), [&](std::uint32_t v) { return v < mesh_.vertices.size(); });
      if (there && has_area(mesh_.vertices[t[0]], mesh_.vertices[t[1]], mesh_.vertices[t[2]])) {
        mesh_.triangles.push_back(t);
      } else {
        ++dropped_;
      }
    }
    return {};
  }

  std::uint64_t dropped() const { return dropped_; }

  /// Without vertices that no triangle has.
  TriangleMesh take() {
    constexpr std::uint32_t kUnused = UINT32_MAX;
    std::vector<std::uint32_t> place(mesh_.vertices.size(), kUnused);
    TriangleMesh used;
    for (Triangle& triangle : mesh_.triangles) {
      for (std::uint32_t& v : triangle) {
        if (place[v] == kUnused) {
          place[v] = static_cast<std::uint32_t>(used.vertices.size());
          used.vertices.push_back(mesh_.vertices[v]);
          if (!mesh_.colors.empty()) used.colors.push_back(mesh_.colors[v]);
        }
        v = place[v];
      }
    }
    used.triangles = std::move(mesh_.triangles);
    return used;
  }

 private:
  TriangleMesh mesh_;
  std::uint64_t dropped_ = 0;
};

#if defined(GVX_WITH_ASSIMP)
/// Hands over one part, which stands where it belongs; `first` vertices came before it.
Status hand_over(const aiMesh& part, bool any_colors, std::uint32_t first, MeshSink& sink) {
  std::vector<Vec3f> places, colors;
  for (unsigned v = 0; v < part.mNumVertices; ++v) {
    const aiVector3D& p = part.mVertices[v];
    places.emplace_back(p.x, p.y, p.z);
    if (!any_colors) continue;
    const aiColor4D color = part.HasVertexColors(0) ? part.mColors[0][v] : aiColor4D(0.8f, 0.8f, 0.8f, 1);
    const auto held = [](float c) { return std::isfinite(c) ? std::clamp(c, 0.0f, 1.0f) : 0.0f; };
    colors.emplace_back(held(color.r), held(color.g), held(color.b));
  }
  GVX_TRY(sink.add_vertices(places, colors));
  std::vector<Triangle> triangles;
  for (unsigned f = 0; f < part.mNumFaces; ++f) {
    const aiFace& face = part.mFaces[f];
    if (face.mNumIndices != 3) continue;
    Triangle& triangle = triangles.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) {
      triangle[k] = face.mIndices[k] < part.mNumVertices ? first + face.mIndices[k] : UINT32_MAX;
    }
  }
  return sink.add_triangles(triangles);
}

Status import(const std::string& path, MeshSink& sink) {
  Assimp::Importer importer;
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  // Only what makes the surface is of use here.
  importer.SetPropertyInteger(AI_CONFIG_PP_RVC_FLAGS,
                              aiComponent_NORMALS | aiComponent_TANGENTS_AND_BITANGENTS |
                                  aiComponent_TEXCOORDS | aiComponent_BONEWEIGHTS | aiComponent_ANIMATIONS |
                                  aiComponent_TEXTURES | aiComponent_LIGHTS | aiComponent_CAMERAS |
                                  aiComponent_MATERIALS);
  const aiScene* scene =
      importer.ReadFile(path, aiProcess_RemoveComponent | aiProcess_Triangulate | aiProcess_SortByPType |
                                  aiProcess_PreTransformVertices | aiProcess_JoinIdenticalVertices);
  if (scene == nullptr) {
    std::string reason = importer.GetErrorString();
    std::replace(reason.begin(), reason.end(), '\n', ' ');
    return Error{path + ": not a mesh that can be read: " + reason};
  }
  bool any_colors = false;
  for (unsigned i = 0; i < scene->mNumMeshes; ++i) any_colors |= scene->mMeshes[i]->HasVertexColors(0);
  std::uint32_t vertices = 0;
  for (unsigned i = 0; i < scene->mNumMeshes; ++i) {
    GVX_TRY(hand_over(*scene->mMeshes[i], any_colors, vertices, sink));
    vertices += scene->mMeshes[i]->mNumVertices;
  }
  return {};
}
#else
Status import(const std::string& path, MeshSink&) {
  return Error{path + ": of meshes this build reads only PLY: it was made without assimp"};
}
#endif

}  // namespace

bool has_area(Vec3f a, Vec3f b, Vec3f c) {
  // Infinite or undefined where a place is.
  const double twice = length(cross(Vec3d(b) - Vec3d(a), Vec3d(c) - Vec3d(a)));
  return twice > 0 && std::isfinite(twice);
}

Box3d TriangleMesh::bounds() const {
  Box3d box{Vec3d(INFINITY), Vec3d(-INFINITY)};
  for (const auto& triangle : triangles) {
    for (const std::uint32_t v : triangle) {
      for (int axis = 0; axis < 3; ++axis) {
        box.minimum[axis] = std::min(box.minimum[axis], double(vertices[v][axis]));
        box.maximum[axis] = std::max(box.maximum[axis], double(vertices[v][axis]));
      }
    }
  }
  return box;
}

bool is_mesh_name(const std::string& path) {
  return std::any_of(kEndings.begin(), kEndings.end(),
                     [&](const char* ending) { return ends_as(path, ending); });
}

Status stream_mesh(const std::string& path, MeshSink& sink, const MeshProgress& progress) {
  if (!is_mesh_name(path)) {
    std::string known;
    for (const char* ending : kEndings) known += std::string(known.empty() ? "" : ", ") + ending;
    return Error{path + ": not a mesh by its name, which would end in one of " + known};
  }
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return Error{path + ": cannot open: no such file"};
  return is_ply(path) ? stream_ply(path, sink, progress) : import(path, sink);
}

Result<TriangleMesh> read_mesh(const std::string& path, MeshReport* report) {
  MeshCollector collector;
  GVX_TRY(stream_mesh(path, collector));
  if (report != nullptr) report->dropped = collector.dropped();
  TriangleMesh mesh = collector.take();
  if (mesh.triangles.empty()) return Error{path + ": there is no triangle in it"};
  return mesh;
}

}  // namespace gvx::io
