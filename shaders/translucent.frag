#version 330 core
#include "lighting.glsl"

uniform sampler2D image;
uniform float alpha;
uniform float alpha_lit;  // in full light; alpha without light

void main() {
  vec3 n = smooth_normal();
  float lit = min(1.0, lambert(n));
  color = vec4(blinn_phong(texture(image, surface_uv).rgb, n), mix(alpha, alpha_lit, lit));
}
