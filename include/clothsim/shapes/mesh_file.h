#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "clothsim/geometry/cloth_surface.h"
#include "clothsim/model/checks.h"
#include "clothsim/model/types.h"
#include "clothsim/shapes/solid.h"

namespace clothsim {

/// A solid or a sheet, and the file it was read from.
struct MeshFile {
  Solid solid;
  std::string uri;         // for other programs, as RViz: package:// or file://
  Vector3 scale{1, 1, 1};  // of the file's coordinates
};

/// Range of the size of a scale.
inline constexpr Range mesh_scale_range{1e-6, 1e6, ""};

/// Reads an STL, OBJ or DAE file. `scale` [m per unit of the file; a negative one mirrors]
/// multiplies the unit that a DAE file names; z is up in all files, also where a DAE file says
/// otherwise, as in RViz. Throws InvalidValue, without a key, for a file that is missing, too large
/// or no solid.
TriangleSoup read_triangles(const std::filesystem::path&, const Vector3& scale);

/// The same with texture coordinates, for a cloth; also of a PLY file.
MeshTriangles read_mesh_triangles(const std::filesystem::path&, const Vector3& scale);

/// The solid in a file, or several where shells overlap, see split_overlapping(). Scenes that read
/// the same unchanged file share the result.
std::vector<std::shared_ptr<const MeshFile>> read_mesh_files(const std::filesystem::path&,
                                                             const std::string& uri,
                                                             const Vector3& scale,
                                                             Bounds = Bounds::solid);

/// The same for a file whose shells do not overlap: throws InvalidValue, without a key, where they
/// do. Those of a sheet may overlap.
std::shared_ptr<const MeshFile> read_mesh_file(const std::filesystem::path&, const std::string& uri,
                                               const Vector3& scale, Bounds = Bounds::solid);

}  // namespace clothsim
