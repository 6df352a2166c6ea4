#version 330 core
// The images of an exact sphere: intersection with the pixel's ray, for any mesh in the colour
// image. The fragments come from a box around the sphere.
#include "truth.glsl"

uniform vec3 translation;  // the sphere's centre relative to the camera [m]
uniform float radius;      // [m]
uniform mat3 turn;         // from the present picture to the last one
uniform vec3 translation_before;
uniform float dip;         // [m] largest depth below its surface of cloth that lies on it

// Cosine below which a sphere counts as seen edge-on and the dip grows no more.
const float steepest = 0.1;

void main() {
  // Half the chord from the ray's distance to the centre, which avoids differences of large
  // squares.
  vec3 ray = pixel_ray();
  float middle = dot(ray, translation);
  vec3 aside = translation - middle * ray;
  float chord_squared = radius * radius - dot(aside, aside);
  if (chord_squared < 0.0) discard;

  // The front of the sphere, or its inside where the camera is within.
  float along = dot(ray, forward.xyz);
  float distance = middle - sqrt(chord_squared);
  if (distance * along < depth_terms.z) distance = middle + sqrt(chord_squared);
  float hit_depth = distance * along;
  if (hit_depth < depth_terms.z || hit_depth > depth_terms.w) discard;
  vec3 outward = (distance * ray - translation) / radius;
  vec3 n = facing(dot(outward, ray) < 0.0 ? outward : -outward, ray);
  show(hit_depth, nowhere(), n, radius * (turn * outward) + translation_before);

  // Moved back by the dip along its normal, so that cloth on the sphere wins the depth test.
  float competing = hit_depth + dip * along / max(abs(dot(outward, ray)), steepest);
  gl_FragDepth = 0.5 + 0.5 * (depth_terms.x + depth_terms.y / competing);
}
