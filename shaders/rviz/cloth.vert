#version 120

// Points of the cloth, lit by RViz's lamp, on the side that faces the camera. They are lifted off
// the cloth to that side, so that the cloth does not flicker against the surface it lies on. Lines
// and points are moved nearer to the camera, along the line of sight, so that the surface does not
// hide them. Light is computed per point and not per pixel, where a software renderer takes most of
// its time.

uniform mat4 world_view;
uniform mat4 projection;
uniform mat4 normal_matrix;  // inverse transpose of world_view
uniform float lift;          // [m]
uniform float nearer;        // [m]
uniform vec4 ambient;
uniform vec4 lamp_color;
uniform vec4 lamp_place;     // in the camera's frame; w is 0: a direction

varying vec4 lit_color;
varying vec2 map_place;

// RViz's ambient light is black: surfaces that the lamp does not reach stay visible by this.
const vec3 least_light = vec3(0.3);

// Where the surface is seen edge-on, neighbouring points may face the camera with different sides:
// below this cosine the light of both sides is mixed.
const float edge_on = 0.2;

void main() {
  vec3 position = (world_view * gl_Vertex).xyz;
  vec3 normal = (normal_matrix * vec4(gl_Normal, 0.0)).xyz;
  // A parallel projection looks along -z everywhere.
  vec3 to_camera = projection[2][3] == 0.0 ? vec3(0.0, 0.0, 1.0) : -normalize(position);
  float side = clamp(dot(normal, to_camera) / edge_on, -1.0, 1.0);  // -1: the back
  position += lift * side * normal + nearer * to_camera;

  float slope = dot(normal, normalize(lamp_place.xyz - lamp_place.w * position));
  float lamp = mix(max(-slope, 0.0), max(slope, 0.0), (1.0 + side) / 2.0);
  vec3 base = max(ambient.rgb, least_light);
  vec3 light = base + (1.0 - base) * lamp * lamp_color.rgb;
  lit_color = vec4(gl_Color.rgb * min(light, 1.0), gl_Color.a);
  map_place = gl_MultiTexCoord0.xy;
  gl_Position = projection * vec4(position, 1.0);
}
