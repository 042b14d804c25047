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

bool finite(Vec3f v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/// Drops triangles that cover nothing, and vertices that no triangle has.
std::uint64_t drop_useless(TriangleMesh& mesh) {
  const auto useless = [&](const std::array<std::uint32_t, 3>& t) {
    for (const std::uint32_t v : t) {
      if (v >= mesh.vertices.size() || !finite(mesh.vertices[v])) return true;
    }
    const Vec3d a(mesh.vertices[t[0]]), b(mesh.vertices[t[1]]), c(mesh.vertices[t[2]]);
    return !(length(cross(b - a, c - a)) > 0);
  };
  const auto kept = std::remove_if(mesh.triangles.begin(), mesh.triangles.end(), useless);
  const auto dropped = static_cast<std::uint64_t>(mesh.triangles.end() - kept);
  mesh.triangles.erase(kept, mesh.triangles.end());
  constexpr std::uint32_t kUnused = UINT32_MAX;
  std::vector<std::uint32_t> place(mesh.vertices.size(), kUnused);
  std::vector<Vec3f> vertices, colors;
  for (auto& triangle : mesh.triangles) {
    for (std::uint32_t& v : triangle) {
      if (place[v] == kUnused) {
        place[v] = static_cast<std::uint32_t>(vertices.size());
        vertices.push_back(mesh.vertices[v]);
        if (!mesh.colors.empty()) colors.push_back(mesh.colors[v]);
      }
      v = place[v];
    }
  }
  mesh.vertices = std::move(vertices);
  mesh.colors = std::move(colors);
  return dropped;
}

#if defined(GVX_WITH_ASSIMP)
/// Puts all meshes of a scene, which stand where they belong, one behind the other.
TriangleMesh joined(const aiScene& scene) {
  TriangleMesh all;
  bool any_colors = false;
  for (unsigned i = 0; i < scene.mNumMeshes; ++i) any_colors |= scene.mMeshes[i]->HasVertexColors(0);
  for (unsigned i = 0; i < scene.mNumMeshes; ++i) {
    const aiMesh& part = *scene.mMeshes[i];
    const auto first = static_cast<std::uint32_t>(all.vertices.size());
    for (unsigned v = 0; v < part.mNumVertices; ++v) {
      const aiVector3D& p = part.mVertices[v];
      all.vertices.emplace_back(p.x, p.y, p.z);
      if (!any_colors) continue;
      const aiColor4D color = part.HasVertexColors(0) ? part.mColors[0][v] : aiColor4D(0.8f, 0.8f, 0.8f, 1);
      const auto held = [](float c) { return std::isfinite(c) ? std::clamp(c, 0.0f, 1.0f) : 0.0f; };
      all.colors.emplace_back(held(color.r), held(color.g), held(color.b));
    }
    for (unsigned f = 0; f < part.mNumFaces; ++f) {
      const aiFace& face = part.mFaces[f];
      if (face.mNumIndices != 3) continue;
      std::array<std::uint32_t, 3> triangle{};
      for (std::size_t k = 0; k < 3; ++k) {
        triangle[k] = face.mIndices[k] < part.mNumVertices ? first + face.mIndices[k] : UINT32_MAX;
      }
      all.triangles.push_back(triangle);
    }
  }
  return all;
}

Result<TriangleMesh> import(const std::string& path) {
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
  return joined(*scene);
}
#else
Result<TriangleMesh> import(const std::string& path) {
  return Error{path + ": of meshes this build reads only PLY: it was made without assimp"};
}
#endif

}  // namespace

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

Result<TriangleMesh> read_mesh(const std::string& path, MeshReport* report) {
  if (!is_mesh_name(path)) {
    std::string known;
    for (const char* ending : kEndings) known += std::string(known.empty() ? "" : ", ") + ending;
    return Error{path + ": not a mesh by its name, which would end in one of " + known};
  }
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return Error{path + ": cannot open: no such file"};
  GVX_ASSIGN(TriangleMesh mesh, is_ply(path) ? read_ply(path) : import(path));
  const std::uint64_t dropped = drop_useless(mesh);
  if (report != nullptr) report->dropped = dropped;
  if (mesh.triangles.empty()) return Error{path + ": there is no triangle in it"};
  return mesh;
}

}  // namespace gvx::io
