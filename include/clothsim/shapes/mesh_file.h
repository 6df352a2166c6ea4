#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "clothsim/model/checks.h"
#include "clothsim/model/types.h"
#include "clothsim/shapes/solid.h"

namespace clothsim {

/// A solid or a sheet, and the file that it is from.
struct MeshFile {
  Solid solid;
  std::string uri;         // that others find it by, as RViz does: package:// or file://
  Vector3 scale{1, 1, 1};  // of its coordinates
};

/// Range of the size of a scale.
inline constexpr Range mesh_scale_range{1e-6, 1e6, ""};

/// Reads an STL, OBJ or DAE file. `scale` [m per unit of the file; a negative one mirrors] comes on
/// top of the unit that a DAE file names; z is up in all, whatever a DAE file says, as in RViz.
/// Throws InvalidValue, without a key, for what is missing, no such file, too large or no solid.
TriangleSoup read_triangles(const std::filesystem::path&, const Vector3& scale);

/// The solid in a file, or several where shells overlap, see split_overlapping(). What other scenes
/// hold of the same file, unchanged, is shared.
std::vector<std::shared_ptr<const MeshFile>> read_mesh_files(const std::filesystem::path&,
                                                             const std::string& uri,
                                                             const Vector3& scale,
                                                             Bounds = Bounds::solid);

/// The same of a file in which none do; throws InvalidValue, without a key, where some do. Of a
/// sheet they may.
std::shared_ptr<const MeshFile> read_mesh_file(const std::filesystem::path&, const std::string& uri,
                                               const Vector3& scale, Bounds = Bounds::solid);

}  // namespace clothsim
