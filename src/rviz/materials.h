#pragma once

#include <OgreMaterial.h>
#include <OgreTexture.h>

#include <string>

#include "clothsim/render/image.h"

// Ogre's materials, in the package's own shaders. Names have to be unique in the process.

namespace clothsim_rviz {

/// Name of this kind that none had before.
std::string new_name(const std::string& kind);

/// The surface, lit, both sides, in the colours of its points, times those of an image where there
/// is one. Throws std::runtime_error where a shader's file cannot be read.
Ogre::MaterialPtr make_surface_material(const Ogre::TexturePtr& image);

/// Lines or points of one colour, brought nearer to the camera than the surface [m]. Throws
/// likewise.
Ogre::MaterialPtr make_flat_material(const Ogre::ColourValue&, double nearer);

/// For points whose opacity is 1, or any.
void set_opaque(Ogre::Material&, bool opaque);

Ogre::TexturePtr make_texture(const clothsim::Image&);

/// Frees what make_... has made; null is left as it is.
void remove(Ogre::MaterialPtr&);
void remove(Ogre::TexturePtr&);

}  // namespace clothsim_rviz
