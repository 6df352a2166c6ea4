// Inputs of the fragments of a surface. The normal faces the camera's side: both sides are lit.
#include "frame.glsl"

in vec3 surface_position;
in vec3 surface_normal;
in vec3 surface_tangent;
in vec2 surface_uv;

layout(location = 0) out vec4 color;  // linear; the framebuffer encodes it as sRGB

float side() { return gl_FrontFacing ? 1.0 : -1.0; }

vec3 smooth_normal() { return side() * safe_normalize(surface_normal); }
