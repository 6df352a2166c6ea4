#version 330 core
#include "bump.glsl"

uniform vec3 base_color;

void main() { color = vec4(blinn_phong(base_color, bumped_normal()), 1.0); }
