#pragma once

#include "clothsim/render/mesh.h"

namespace clothsim {

/// The texture coordinate that grows along a tube; the other one goes around it.
enum class TubeAlong { u, v };

/// A tube of `radius` [m] about the line through N >= 2 points, with round ends. Its first N
/// vertices are the points themselves, for lines between them; they have no normals. Always finite.
Mesh tube_mesh(const Points& line, double radius, TubeAlong);

}  // namespace clothsim
