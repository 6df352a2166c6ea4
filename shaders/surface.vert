#version 330 core
#include "frame.glsl"

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec3 tangent;
layout(location = 3) in vec2 uv;
layout(location = 4) in vec3 position_before;  // at the last picture
layout(location = 5) in vec3 normal_before;

uniform mat3 rotation;      // from the mesh's frame to the world's axes
uniform vec3 translation;   // of the mesh's origin, relative to the camera [m]
uniform mat3 rotation_before;
uniform vec3 translation_before;  // relative to the camera then [m]
uniform float displacement; // [m] along the normal for a height of 1
uniform float shrinkage;    // [m] against the normal, so that cloth on the surface stays visible
uniform sampler2D height_map;

out vec3 surface_position;  // relative to the camera [m]
out vec3 surface_normal;
out vec3 surface_tangent;
out vec2 surface_uv;
out vec3 surface_before;    // relative to the camera of the last picture [m]

void main() {
  float lift = -shrinkage;
  if (displacement != 0.0) lift += displacement * textureLod(height_map, uv, 0.0).r;
  vec3 moved = position + lift * normal;

  surface_position = rotation * moved + translation;
  surface_normal = rotation * normal;
  surface_tangent = rotation * tangent;
  surface_uv = uv;
  surface_before =
      rotation_before * (position_before + lift * normal_before) + translation_before;

  gl_Position = clip_from_eye * vec4(surface_position, 1.0);
}
