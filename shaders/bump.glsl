// Normal of a height map on the surface.
#include "lighting.glsl"

uniform sampler2D height_map;
uniform float height_scaling;
uniform float normal_scaling;

// (-dU, -dV, 1) through the tangent, bitangent, normal matrix; dU = (h(u + 1/w, v) - h(u, v)) *
// height_scaling * normal_scaling
vec3 bumped_normal() {
  vec2 texel = 1.0 / vec2(textureSize(height_map, 0));
  float here = texture(height_map, surface_uv).r;
  float right = texture(height_map, surface_uv + vec2(texel.x, 0.0)).r;
  float above = texture(height_map, surface_uv + vec2(0.0, texel.y)).r;
  float scale = height_scaling * normal_scaling;

  vec3 n = safe_normalize(surface_normal);
  vec3 t = safe_normalize(surface_tangent - n * dot(n, surface_tangent));
  vec3 b = cross(n, t);
  return side() * safe_normalize(n - scale * ((right - here) * t + (above - here) * b));
}
