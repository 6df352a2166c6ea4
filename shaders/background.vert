#version 330 core
#include "frame.glsl"

// One triangle that covers the picture, with the ray of each corner.
uniform mat3 ray_from_ndc;

out vec3 ray;

void main() {
  vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  ray = ray_from_ndc * vec3(corner, 1.0);
  gl_Position = vec4(corner, 0.0, 1.0);
}
