// A point light and ambient light on a surface with normal n.
#include "surface.glsl"
#include "shadow.glsl"

uniform float ka;     // 0 switches the component off, as with kd and ks
uniform float kd;
uniform float ks;
uniform float power;

// A light on the surface itself gives a bright spot, not infinity.
const float nearest_light_squared = 1e-6;  // [m^2]

struct Incoming {
  vec3 direction;      // l, from the surface to the light
  float irradiance;    // I / r^2, reduced by shadow
};

Incoming incoming_light() {
  vec3 to_light = light_position.xyz - surface_position;
  float squared = max(dot(to_light, to_light), nearest_light_squared);
  return Incoming(safe_normalize(to_light), light.x / squared * unshadowed(to_light));
}

// (I / r^2) max(0, n.l)
float lambert(vec3 n) {
  Incoming incoming = incoming_light();
  return incoming.irradiance * max(0.0, dot(n, incoming.direction));
}

// ka Ia + kd (I / r^2) max(0, n.l) + ks (I / r^2) max(0, n.h)^p  (Blinn 1977), ka and kd in the colour
// of the surface, highlights in that of the light
vec3 blinn_phong(vec3 albedo, vec3 n) {
  Incoming incoming = incoming_light();
  vec3 h = safe_normalize(incoming.direction - safe_normalize(surface_position));
  float highlight = pow(max(0.0, dot(n, h)), power);
  return (ka * light.y + kd * lambert(n)) * albedo + ks * incoming.irradiance * highlight;
}
