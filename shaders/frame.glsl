// Uniforms of a whole picture. Positions are relative to the camera, along the world's axes, so
// that they stay small wherever the scene is.
layout(std140) uniform Frame {
  mat4 clip_from_eye;
  vec4 right;           // xyz: the axes of the optical frame
  vec4 down;
  vec4 forward;
  vec4 depth_terms;     // x, y: clip z = x * depth + y; z, w: near and far [m]
  vec4 light_position;  // xyz [m]
  vec4 light;           // x: intensity I [1 at 1 m], y: ambient intensity Ia
  mat4 shadow_from_eye; // to the shadow map's clip space, if there is one
  vec4 shadow;          // x: size of its pixels 1 m from the light [m]
};

// Unit vector, or zero for a zero vector; never NaN.
vec3 safe_normalize(vec3 v) { return v * inversesqrt(max(dot(v, v), 1e-30)); }
