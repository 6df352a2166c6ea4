#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "clothsim/render/mesh.h"
#include "clothsim/shapes/shape.h"

namespace clothsim {

/// A primitive that viewers such as RViz draw without a mesh; its axes are those of the shape's own
/// frame, that of a cylinder is z.
struct Primitive {
  enum class Kind { ball, cylinder, box, file };
  Kind kind;
  Vector3 size;             // [m] along each axis; for a file the scale of its coordinates
  Vector3 center{0, 0, 0};  // [m]
  std::string uri = "";     // of a file
};

/// The drawing of a shape.
struct ShapeDrawing {
  /// Its mesh in its own frame, `segments` around and along. A sphere's u goes around +z and its v
  /// from pole to pole; a capsule and a cylinder have the same u, and v in proportion to the length
  /// of the way (from the middle of one flat end to that of the other); a box has u and v from 0 to
  /// 1 on each face; a plane is a square of side `extent` [m] about the origin, u and v in metres
  /// along x and y, so that textures repeat. A mesh keeps its triangles: see solid_mesh().
  std::function<Mesh(int segments, double extent)> mesh;
  std::vector<Primitive> primitives;
  bool is_flat = false;                      // few segments suffice, unless it is displaced
  std::optional<double> sphere_radius = {};  // [m] of a sphere, which is drawn exactly
};

ShapeDrawing drawing_of(const Shape&);

}  // namespace clothsim
