#version 120

uniform sampler2D map;

varying vec4 lit_color;
varying vec2 map_place;

void main() { gl_FragColor = vec4(texture2D(map, map_place).rgb * lit_color.rgb, lit_color.a); }
