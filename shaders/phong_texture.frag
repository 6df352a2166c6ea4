#version 330 core
#include "lighting.glsl"

uniform sampler2D image;

void main() { color = vec4(blinn_phong(texture(image, surface_uv).rgb, smooth_normal()), 1.0); }
