#version 330 core
// The images of a mesh's surface.
#include "truth.glsl"

in vec3 surface_position;
in vec3 surface_normal;
in vec2 surface_uv;
in float surface_depth;
in vec3 surface_before;

uniform float displacement;

// What is displaced has the normal of the triangle that is drawn: its own is of the mesh before.
vec3 normal_of_surface() {
  if (displacement == 0.0) return (gl_FrontFacing ? 1.0 : -1.0) * safe_normalize(surface_normal);
  vec3 n = safe_normalize(cross(dFdx(surface_position), dFdy(surface_position)));
  return dot(n, surface_position) < 0.0 ? n : -n;
}

void main() {
  vec3 n = facing(normal_of_surface(), safe_normalize(surface_position));
  show(surface_depth, surface_uv, n, surface_before);
}
