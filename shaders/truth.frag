#version 330 core
// Depth and id of a mesh.
in float surface_depth;

uniform float id;

layout(location = 0) out float depth;  // [m]
layout(location = 1) out float mask;

void main() {
  depth = surface_depth;
  mask = id / 255.0;
}
