#version 330 core
// Depth and id of an exact sphere: the ray through the pixel against it, whatever mesh stands for it
// in the colour image. The fragments come from a box around it.
#include "frame.glsl"

in vec3 surface_position;

uniform vec3 translation;  // the sphere's centre relative to the camera [m]
uniform float radius;      // [m]
uniform float dip;         // [m] how far cloth that lies on it may be below its surface
uniform float id;

layout(location = 0) out float depth;  // [m]
layout(location = 1) out float mask;

// Cosine below which a sphere is seen edge on and the dip grows no more.
const float steepest = 0.1;

void main() {
  // Half the chord from the ray's distance to the centre: no difference of large squares.
  vec3 ray = safe_normalize(surface_position);
  float middle = dot(ray, translation);
  vec3 aside = translation - middle * ray;
  float chord_squared = radius * radius - dot(aside, aside);
  if (chord_squared < 0.0) discard;

  // The front of the sphere, or its inside where the camera is within.
  float along = dot(ray, forward.xyz);
  float distance = middle - sqrt(chord_squared);
  if (distance * along < depth_terms.z) distance = middle + sqrt(chord_squared);
  depth = distance * along;
  if (depth < depth_terms.z || depth > depth_terms.w) discard;
  mask = id / 255.0;

  // Moved back by the dip along its normal, the sphere loses the pixel to cloth that lies on it.
  vec3 normal = (distance * ray - translation) / radius;
  float competing = depth + dip * along / max(abs(dot(normal, ray)), steepest);
  gl_FragDepth = 0.5 + 0.5 * (depth_terms.x + depth_terms.y / competing);
}
