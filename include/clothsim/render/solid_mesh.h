#pragma once

#include "clothsim/render/mesh.h"
#include "clothsim/shapes/solid.h"

namespace clothsim {

/// Mesh of a solid of triangles, of a sheet both sides, grown by `padding` [m] along its normals.
/// Corners are smooth where faces meet at less than 40 degrees. u and v are in metres along the two
/// axes that a face lies best along, so that textures repeat.
Mesh solid_mesh(const Solid&, double padding);

}  // namespace clothsim
