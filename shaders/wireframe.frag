#version 330 core

uniform vec3 base_color;

layout(location = 0) out vec4 color;

void main() { color = vec4(base_color, 1.0); }
