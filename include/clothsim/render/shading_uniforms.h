#pragma once

#include <string>

#include "clothsim/render/shader_program.h"
#include "clothsim/render/shading.h"
#include "clothsim/render/texture_cache.h"

namespace clothsim {

/// The file of the fragment shader that draws a shading.
std::string fragment_shader(const Shading&);

/// Texture unit of a shadow map. No other texture uses it.
constexpr int shadow_unit = 3;

/// Sets the parameters and textures of a shading in its program, which is in use. The colours of a
/// wireframe are set line by line, elsewhere.
void set_shading(const Shading&, const ShaderProgram&, TextureCache&);

/// Sets the height map of a shading that moves vertices, and no displacement for the others.
void set_displacement(const Shading&, const ShaderProgram&, TextureCache&);

/// sRGB to linear light, per channel (IEC 61966-2-1).
Color linear_from_srgb(const Color&);

/// Binds a cube map as the environment.
void set_environment(const std::shared_ptr<const CubeMap>&, const ShaderProgram&, TextureCache&);

}  // namespace clothsim
