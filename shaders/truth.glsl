// The images of the surfaces themselves, of meshes and of exact spheres. One that is not wanted has no
// target: what is written to it goes nowhere.
#include "frame.glsl"

uniform float id;

layout(location = 0) out float depth;  // along the optical axis [m]
layout(location = 1) out float mask;
layout(location = 2) out vec2 uv;      // of the cloth

const float cloth_id = 1.0;

vec2 nowhere() { return vec2(intBitsToFloat(0x7fc00000)); }  // NaN

void show(float surface_depth, vec2 surface_uv) {
  depth = surface_depth;
  mask = id / 255.0;
  uv = id == cloth_id ? surface_uv : nowhere();
}
