#version 330 core
// The images of a mesh's surface.
#include "truth.glsl"

in vec3 surface_position;
in vec3 surface_normal;
in vec2 surface_uv;
in vec3 surface_before;

uniform float displacement;

// Rasterizers round corners to 1/256 of a pixel, so interpolated values belong to a point that far
// beside the pixel's ray. Here the ray is intersected with the triangle's plane; these steps, in
// pixels, correct every value that is linear in the plane.
vec2 steps_to_ray(vec3 ray) {
  vec3 x = dFdx(surface_position), y = dFdy(surface_position), n = cross(x, y);
  vec3 way = dot(n, surface_position) / dot(n, ray) * ray - surface_position;
  if (!(dot(way, way) < dot(x, x) + dot(y, y))) return vec2(0.0);  // seen edge-on
  return vec2(dot(cross(way, y), n), dot(cross(x, way), n)) / max(dot(n, n), 1e-30);
}

vec2 along(vec2 steps, vec2 a) { return a + steps.x * dFdx(a) + steps.y * dFdy(a); }
vec3 along(vec2 steps, vec3 a) { return a + steps.x * dFdx(a) + steps.y * dFdy(a); }

// Displaced surfaces get the normal of the drawn triangle: the smooth one is that of the mesh
// without displacement.
vec3 normal_of_surface(vec3 smooth_normal) {
  if (displacement == 0.0) return (gl_FrontFacing ? 1.0 : -1.0) * safe_normalize(smooth_normal);
  vec3 n = safe_normalize(cross(dFdx(surface_position), dFdy(surface_position)));
  return dot(n, surface_position) < 0.0 ? n : -n;
}

void main() {
  vec3 ray = pixel_ray();
  vec2 steps = steps_to_ray(ray);
  vec3 n = facing(normal_of_surface(along(steps, surface_normal)), ray);
  show(dot(along(steps, surface_position), forward.xyz), along(steps, surface_uv), n,
       along(steps, surface_before));
}
