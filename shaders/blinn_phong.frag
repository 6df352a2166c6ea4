#version 330 core
#include "lighting.glsl"

uniform vec3 base_color;

void main() { color = vec4(blinn_phong(base_color, smooth_normal()), 1.0); }
