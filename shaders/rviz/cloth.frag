#version 120

varying vec4 lit_color;

void main() { gl_FragColor = lit_color; }
