#include "clothsim/shapes/mesh_file.h"

#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cctype>
#include <cmath>
#include <fstream>
#include <map>
#include <mutex>
#include <sstream>
#include <tuple>
#include <utility>

#include "clothsim/model/checks.h"
#include "clothsim/shapes/shells.h"

namespace clothsim {
namespace {

namespace fs = std::filesystem;

/// Far more than a collider needs, and small enough to hold in memory.
constexpr std::uintmax_t max_bytes = 500'000'000;
constexpr std::size_t max_triangles = 2'000'000;
constexpr int deepest_nodes = 200;

constexpr Range coordinate_range{-1e6, 1e6, "m"};

std::string extension_of(const fs::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

void check_file(const fs::path& path, bool may_be_ply = false) {
  const std::string extension = extension_of(path);
  const bool is_ply = may_be_ply && extension == ".ply";
  if (extension != ".stl" && extension != ".obj" && extension != ".dae" && !is_ply) {
    throw InvalidValue({}, '"' + shortened(path.string(), 200) + '"',
                       may_be_ply ? "a file that ends in .stl, .obj, .dae or .ply"
                                  : "a file that ends in .stl, .obj or .dae");
  }
  std::error_code error;
  const std::uintmax_t size = fs::file_size(path, error);
  if (error) {
    throw InvalidValue({}, '"' + shortened(path.string(), 200) + "\": " + error.message(),
                       "a mesh file");
  }
  if (size > max_bytes) {
    throw InvalidValue({}, std::to_string(size) + " bytes", "at most " + std::to_string(max_bytes));
  }
}

/// Throws InvalidValue where the header of a PLY file promises more elements than the file can
/// have: Assimp would count them all.
void check_ply_header(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  for (std::string line; std::getline(file, line) && line.rfind("end_header", 0) != 0;) {
    std::istringstream words(line);
    std::string element, name;
    double count = 0;
    if (!(words >> element >> name >> count) || element != "element") continue;
    if (count <= static_cast<double>(fs::file_size(path))) continue;
    throw InvalidValue({}, "a header with " + shortened(line, 100), "as many as the file has");
  }
}

/// Throws InvalidValue for a face with a vertex that its mesh lacks, which Assimp accepts from PLY.
void check_indices(const aiScene& scene) {
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
    const aiMesh& mesh = *scene.mMeshes[m];
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      for (unsigned k = 0; k < mesh.mFaces[f].mNumIndices; ++k) {
        const unsigned vertex = mesh.mFaces[f].mIndices[k];
        if (vertex < mesh.mNumVertices) continue;
        throw InvalidValue({}, "vertex " + std::to_string(vertex) + " in face " + std::to_string(f),
                           "one of " + std::to_string(mesh.mNumVertices) + " vertices");
      }
    }
  }
}

Vector3 to_vector(const aiVector3D& v) { return {v.x, v.y, v.z}; }

/// Adds the triangles of a node and those below it.
void add_node(const aiScene& scene, const aiNode& node, const aiMatrix4x4& parent,
              const Vector3& scale, int depth, MeshTriangles& soup) {
  if (depth > deepest_nodes) throw InvalidValue({}, "nodes within nodes", "fewer of them");
  const aiMatrix4x4 pose = depth == 0 ? parent : parent * node.mTransformation;
  for (unsigned m = 0; m < node.mNumMeshes; ++m) {
    const aiMesh& mesh = *scene.mMeshes[node.mMeshes[m]];
    const int first = static_cast<int>(soup.vertices.size());
    if (soup.triangles.size() + mesh.mNumFaces > max_triangles) {
      throw InvalidValue({}, "more than " + std::to_string(max_triangles) + " triangles", "fewer");
    }
    for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
      soup.vertices.push_back(scale.cwiseProduct(to_vector(pose * mesh.mVertices[i])));
      for (int axis = 0; axis < 3; ++axis) {
        check_range("vertex", soup.vertices.back()[axis], coordinate_range);
      }
      if (!mesh.HasTextureCoords(0)) continue;
      soup.uv.emplace_back(mesh.mTextureCoords[0][i].x, mesh.mTextureCoords[0][i].y);
    }
    for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
      const aiFace& face = mesh.mFaces[i];
      if (face.mNumIndices != 3) continue;  // a point or a line
      soup.triangles.push_back({first + static_cast<int>(face.mIndices[0]),
                                first + static_cast<int>(face.mIndices[1]),
                                first + static_cast<int>(face.mIndices[2])});
    }
  }
  for (unsigned i = 0; i < node.mNumChildren; ++i) {
    add_node(scene, *node.mChildren[i], pose, scale, depth + 1, soup);
  }
}

/// The scale of the root, without its rotation to y up.
aiMatrix4x4 unit_of(const aiNode& root) {
  const double volume = std::abs(aiMatrix3x3(root.mTransformation).Determinant());
  const auto unit = static_cast<float>(std::cbrt(volume));
  aiMatrix4x4 scaling;
  aiMatrix4x4::Scaling(aiVector3D(unit), scaling);
  return scaling;
}

}  // namespace

MeshTriangles read_mesh_triangles(const fs::path& path, const Vector3& scale) {
  check_file(path, true);
  if (extension_of(path) == ".ply") check_ply_header(path);
  Assimp::Importer importer;
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE,
                              aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  const aiScene* scene = importer.ReadFile(path.string(), 0);
  if (scene) {
    check_indices(*scene);
    scene = importer.ApplyPostProcessing(aiProcess_Triangulate | aiProcess_SortByPType);
  }
  if (!scene || !scene->mRootNode) {
    throw InvalidValue({}, shortened(importer.GetErrorString(), 200), "a mesh");
  }
  MeshTriangles soup;
  add_node(*scene, *scene->mRootNode, unit_of(*scene->mRootNode), scale, 0, soup);
  if (soup.triangles.empty()) throw InvalidValue({}, "no triangles", "a surface");
  if (soup.uv.size() != soup.vertices.size()) soup.uv.clear();  // a part has none
  return soup;
}

TriangleSoup read_triangles(const fs::path& path, const Vector3& scale) {
  check_file(path);
  MeshTriangles read = read_mesh_triangles(path, scale);
  return {std::move(read.vertices), std::move(read.triangles)};
}

std::vector<std::shared_ptr<const MeshFile>> read_mesh_files(const fs::path& path,
                                                             const std::string& uri,
                                                             const Vector3& scale, Bounds bounds) {
  using Key = std::tuple<std::string, std::string, double, double, double, Bounds>;
  struct Known {
    fs::file_time_type changed;
    std::vector<std::weak_ptr<const MeshFile>> files;
  };
  static std::mutex mutex;
  static std::map<Key, Known> all_known;
  check_file(path);
  const fs::file_time_type changed = fs::last_write_time(path);
  const std::lock_guard lock(mutex);
  Known& known = all_known[{fs::weakly_canonical(path).string(), uri, scale.x(), scale.y(),
                            scale.z(), bounds}];
  std::vector<std::shared_ptr<const MeshFile>> files;
  for (const auto& file : known.files) files.push_back(file.lock());
  const bool are_held = std::all_of(files.begin(), files.end(), [](const auto& f) { return f; });
  if (!files.empty() && are_held && known.changed == changed) return files;

  files.clear();
  const auto add = [&](Solid solid) {
    files.push_back(std::make_shared<const MeshFile>(MeshFile{std::move(solid), uri, scale}));
  };
  Solid all(read_triangles(path, scale), bounds);
  std::vector<TriangleSoup> groups;
  if (!all.is_sheet()) groups = split_overlapping(all);
  if (groups.size() <= 1) {
    add(std::move(all));
  } else {
    for (const TriangleSoup& group : groups) add(Solid(group));
  }
  known = {changed, {files.begin(), files.end()}};
  return files;
}

std::shared_ptr<const MeshFile> read_mesh_file(const fs::path& path, const std::string& uri,
                                               const Vector3& scale, Bounds bounds) {
  const auto files = read_mesh_files(path, uri, scale, bounds);
  if (files.size() == 1) return files.front();
  throw InvalidValue({}, "shells that touch or overlap", "a collider, with a file, for each");
}

}  // namespace clothsim
