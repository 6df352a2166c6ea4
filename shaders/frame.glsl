// What holds for a whole picture. Positions are relative to the camera, along the world's axes, so
// that they stay small wherever the scene is.
layout(std140) uniform Frame {
  mat4 clip_from_eye;
  vec4 forward;         // xyz: the optical axis
  vec4 depth_terms;     // x, y: clip z = x * depth + y; z, w: near and far [m]
  vec4 light_position;  // xyz [m]
  vec4 light;           // x: intensity I [1 at 1 m], y: ambient intensity Ia
};

// Unit vector, or zero for a zero vector; never NaN.
vec3 safe_normalize(vec3 v) { return v * inversesqrt(max(dot(v, v), 1e-30)); }

// The depth [m] at which a point of a round collider competes for its pixel. The cloth's flat
// triangles dip below a sphere between their corners; moved back by that dip along its normal, the
// sphere loses against the cloth that lies on it. What is shown as depth stays exact.
float competing_depth(float depth, vec3 position, vec3 normal, float dip) {
  vec3 ray = safe_normalize(position);
  return depth + dip * dot(ray, forward.xyz) / max(abs(dot(normal, ray)), 0.1);
}
