#version 330 core
#include "surface.glsl"

// Inverts the framebuffer's sRGB encoding: a normal is data and must reach the image unchanged.
vec3 linear_from_srgb(vec3 c) {
  return mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), greaterThan(c, vec3(0.04045)));
}

void main() { color = vec4(linear_from_srgb(0.5 * (1.0 + smooth_normal())), 1.0); }
