#version 330 core
// Into a shadow map: depth alone.
void main() {}
