#version 330 core
#include "lighting.glsl"

uniform vec3 base_color;
uniform float levels;
uniform float ambient;

void main() {
  float diffuse = min(1.0, kd * lambert(smooth_normal()));
  color = vec4(base_color * (floor(diffuse * levels) / levels + ambient), 1.0);
}
