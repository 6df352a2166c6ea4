#version 330 core
#include "frame.glsl"

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec3 tangent;
layout(location = 3) in vec2 uv;

uniform mat3 rotation;      // from the mesh's frame to the world's axes
uniform vec3 translation;   // of the mesh's origin, relative to the camera [m]
uniform float displacement; // [m] along the normal for a height of 1
uniform float dip;          // [m], see competing_depth
uniform sampler2D height_map;

out vec3 surface_position;  // relative to the camera [m]
out vec3 surface_normal;
out vec3 surface_tangent;
out vec2 surface_uv;
out float surface_depth;    // along the optical axis [m]

void main() {
  vec3 moved = position;
  if (displacement != 0.0) moved += normal * (displacement * textureLod(height_map, uv, 0.0).r);

  surface_position = rotation * moved + translation;
  surface_normal = rotation * normal;
  surface_tangent = rotation * tangent;
  surface_uv = uv;
  surface_depth = dot(surface_position, forward.xyz);

  gl_Position = clip_from_eye * vec4(surface_position, 1.0);
  if (dip > 0.0 && surface_depth > 0.0) {
    float depth = competing_depth(surface_depth, surface_position, surface_normal, dip);
    gl_Position.z = (depth_terms.x + depth_terms.y / depth) * surface_depth;
  }
}
