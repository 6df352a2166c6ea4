#pragma once

#include <OgreMaterial.h>
#include <OgreTexture.h>

#include <string>

#include "clothsim/render/image.h"

// Ogre's materials, with the package's own shaders. Names must be unique in the process.

namespace clothsim_rviz {

/// A new name of this kind.
std::string new_name(const std::string& kind);

/// The surface, lit, both sides, in the colours of its points, times those of an image if there is
/// one. Throws std::runtime_error where a shader's file cannot be read.
Ogre::MaterialPtr make_surface_material(const Ogre::TexturePtr& image);

/// Lines or points of one colour, closer to the camera than the surface [m]. Throws
/// std::runtime_error where a shader's file cannot be read.
Ogre::MaterialPtr make_flat_material(const Ogre::ColourValue&, double nearer);

/// Whether all points have an opacity of 1.
void set_opaque(Ogre::Material&, bool opaque);

Ogre::TexturePtr make_texture(const clothsim::Image&);

/// Frees a material of the functions above; null is ignored.
void remove(Ogre::MaterialPtr&);
void remove(Ogre::TexturePtr&);

}  // namespace clothsim_rviz
