#pragma once

#include "clothsim/model/cloth.h"
#include "clothsim/render/renderer.h"
#include "clothsim/render/shape_drawing.h"

namespace clothsim {

/// One renderer for all tests of a program: a context takes longer to make than a small image.
Renderer& shared_renderer();

/// Draws all three images.
Images draw(const Snapshot&, const Camera&);

/// Channel of a pixel of the colour image, 0 to 255.
int channel(const Images&, int u, int v, int c);

/// Whether all pixels around (u, v), itself included, have the id.
bool surrounded_by(const Images&, int u, int v, int id);

/// The ray through the centre of a pixel, from the camera's position; its part along the optical
/// axis is 1, so that a factor on it is a depth.
Vector3 pixel_ray(const Camera&, double u, double v);

/// The framebuffer's value of linear light, 0 to 255, not rounded (IEC 61966-2-1).
double srgb_byte(double linear);
double linear_of_srgb(double srgb);

/// A snapshot with a flat cloth of columns x rows points on the unit square at height 0, facing +z.
Snapshot flat_cloth(int columns, int rows);

/// A cloth of any triangles, all uv zero, no springs.
Snapshot triangle_cloth(const Points& positions, std::vector<std::array<int, 3>> triangles);

/// The same cloth elsewhere.
void move_cloth(Snapshot&, const Points& positions);

/// The cloth of a snapshot with normals and tangents, as a mesh of the world.
Mesh cloth_mesh(const Snapshot&);

/// A collider's mesh in the world.
Mesh collider_mesh(const ColliderView&);

}  // namespace clothsim
