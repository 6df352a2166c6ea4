#version 330 core
// Draws a shadow map: depth alone.
void main() {}
