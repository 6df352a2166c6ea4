// A cube map around the scene. Cube maps have y up and are left-handed: face +y is the sky, face +z
// looks along the world's +y.
uniform samplerCube environment;

vec3 environment_color(vec3 direction) { return texture(environment, direction.xzy).rgb; }
