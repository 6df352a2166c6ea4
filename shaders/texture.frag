#version 330 core
#include "surface.glsl"

uniform sampler2D image;

void main() { color = vec4(texture(image, surface_uv).rgb, 1.0); }
