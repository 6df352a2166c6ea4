#version 330 core
#include "lighting.glsl"

uniform sampler2D image;
uniform float alpha;
uniform float alpha_lit;  // where the light falls in full; alpha where none falls

void main() {
  vec3 n = smooth_normal();
  float lit = min(1.0, lambert(n));
  color = vec4(blinn_phong(texture(image, surface_uv).rgb, n), mix(alpha, alpha_lit, lit));
}
