#version 330 core
#include "environment.glsl"

in vec3 ray;

layout(location = 0) out vec4 color;

void main() { color = vec4(environment_color(ray), 1.0); }
