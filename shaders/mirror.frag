#version 330 core
#include "surface.glsl"
#include "environment.glsl"

void main() {
  color = vec4(environment_color(reflect(safe_normalize(surface_position), smooth_normal())), 1.0);
}
