// The images of the surfaces themselves, of meshes and of exact spheres. An image that is not
// wanted has no target: its output is discarded.
#include "frame.glsl"

uniform float id;
uniform mat3 ray_of_pixel;  // the direction of (u, v, 1) from the camera
uniform mat3 pixel_before;  // from a position there to (u, v, 1) * depth in the last picture
uniform float near_before;  // [m] the near plane then; infinity: no last picture of this object

layout(location = 0) out float depth;  // along the optical axis [m]
layout(location = 1) out float mask;
layout(location = 2) out vec2 uv;      // of the cloth
layout(location = 3) out vec4 normal;  // in the optical frame, towards the camera
layout(location = 4) out vec2 flow;    // pixels since the last picture

const float cloth_id = 1.0;

vec2 nowhere() { return vec2(intBitsToFloat(0x7fc00000)); }  // NaN

vec3 pixel_ray() { return safe_normalize(ray_of_pixel * vec3(gl_FragCoord.xy - 0.5, 1.0)); }

// The normal on the visible side. Smooth normals lean away from the camera near an outline: those
// are made perpendicular to the ray.
vec3 facing(vec3 n, vec3 ray) {
  vec3 bent = n - max(0.0, dot(n, ray)) * ray;
  return dot(bent, bent) > 1e-12 ? safe_normalize(bent) : -ray;
}

vec2 way_from(vec3 before) {
  vec3 p = pixel_before * before;
  return p.z > near_before ? gl_FragCoord.xy - 0.5 - p.xy / p.z : nowhere();
}

void show(float surface_depth, vec2 surface_uv, vec3 n, vec3 before) {
  depth = surface_depth;
  mask = id / 255.0;
  uv = id == cloth_id ? surface_uv : nowhere();
  normal = vec4(dot(n, right.xyz), dot(n, down.xyz), dot(n, forward.xyz), 0.0);
  flow = way_from(before);
}
