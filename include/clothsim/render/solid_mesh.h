#pragma once

#include "clothsim/render/mesh.h"
#include "clothsim/shapes/solid.h"

namespace clothsim {

/// Mesh of a solid of triangles, grown by `padding` [m] along its normals; for a sheet, both sides.
/// Corners are smooth where faces meet at less than 40 degrees. u and v are in metres along the two
/// axes closest to a face's plane, so that textures repeat.
Mesh solid_mesh(const Solid&, double padding);

}  // namespace clothsim
