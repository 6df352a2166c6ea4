// The share of the light that reaches a surface, by a shadow map where the picture has one.
#ifdef SHADOWS
uniform sampler2DShadow shadow_map;

// Pixels of the map by which a surface is lifted along its normal, and towards the light, so that
// it does not shade itself (Holbert 2011, "Normal offset shadows").
const vec2 lift = vec2(2.0, 1.0);

float unshadowed(vec3 to_light) {
  vec3 l = safe_normalize(to_light), n = safe_normalize(surface_normal);
  float pixel = shadow.x * length(to_light);  // [m]
  float slope = sqrt(max(0.0, 1.0 - dot(n, l) * dot(n, l)));
  vec3 lifted = surface_position + pixel * (lift.x * slope * sign(dot(n, l)) * n + lift.y * l);
  vec4 clip = shadow_from_eye * vec4(lifted, 1.0);
  vec3 place = 0.5 + 0.5 * clip.xyz / clip.w;
  bool beyond = clip.w <= 0.0 || any(lessThan(place.xy, vec2(0.0))) ||
                any(greaterThan(place.xy, vec2(1.0)));
  return beyond ? 1.0 : texture(shadow_map, vec3(place.xy, min(place.z, 1.0)));
}
#else
float unshadowed(vec3 to_light) { return 1.0; }
#endif
