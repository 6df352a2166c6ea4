#version 120

// Lines and points, without light.

uniform vec4 surface_color;

void main() { gl_FragColor = surface_color; }
