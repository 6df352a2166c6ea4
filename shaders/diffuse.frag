#version 330 core
#include "lighting.glsl"

uniform vec3 base_color;

void main() { color = vec4(kd * base_color * lambert(smooth_normal()), 1.0); }
