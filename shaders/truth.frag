#version 330 core
// The images of a mesh's surface.
#include "truth.glsl"

in vec2 surface_uv;
in float surface_depth;

void main() { show(surface_depth, surface_uv); }
