#pragma once

#include <memory>
#include <vector>

#include "clothsim/model/cloth.h"
#include "clothsim/render/shading.h"
#include "clothsim/shapes/collider.h"

namespace clothsim {

/// A point light; `ambient` comes from all directions.
struct Light {
  Vector3 position{1.5, -1, 3};  // [m] in the world
  double intensity = 10;         // irradiance of a surface 1 m away that faces it
  double ambient = 1;
  bool shadows = false;  // of all objects except planes and wireframes
};

/// The background of all objects: the sky if there is one, else the colour.
struct Background {
  Color color{0.1, 0.1, 0.12};
  std::shared_ptr<const CubeMap> sky;
};

/// A collider to draw. A plane is drawn as a square about the origin of its own frame; for a plane
/// and a box, segments matter for displacement only.
struct ColliderView {
  Shape shape = Sphere{0.2};
  Pose pose;  // of the shape's own frame in the world
  Shading shading = BlinnPhong{};
  int segments = 64;   // of its mesh, around and along
  double extent = 10;  // [m] side of the square of a plane
  bool visible = true;
};

/// The scene at one instant. Shared data is never modified: a renderer uploads it once and
/// identifies it by its address.
struct Snapshot {
  double time = 0;                          // [s] of this instant, for random noise
  std::shared_ptr<const Cloth> cloth;       // null: none
  std::shared_ptr<const Points> positions;  // [m], N x 3
  Shading cloth_shading = BlinnPhong{};
  std::vector<Shading> cloth_shadings;  // of several cloths, one each; empty: all as cloth_shading
  std::vector<ColliderView> colliders;  // at most 254, less one for each cloth after the first
  Light light;
  Background background;
};

/// Throw InvalidValue with keys such as {"intensity"}, {"segments"}.
void validate(const Light&);
void validate(const Background&);
void validate(const ColliderView&);

}  // namespace clothsim
