#pragma once

#include <OgreMaterial.h>
#include <OgreVertexIndexData.h>
#include <clothsim/ClothState.h>
#include <clothsim/ClothTopology.h>

#include <array>
#include <memory>
#include <vector>

#include "primitive.h"

namespace Ogre {
class SceneNode;
}

namespace clothsim_rviz {

/// sRGB and opacity.
using Rgba = std::array<std::uint8_t, 4>;

/// A cloth in Ogre's scene: one vertex buffer, rewritten in place, and the primitives that use it.
class ClothVisual {
 public:
  enum Part { surface, structural, shear, bending, pins, held, part_count };

  /// Below `node`, which must outlive this. Throws std::runtime_error where a shader cannot be
  /// read.
  explicit ClothVisual(Ogre::SceneNode* node);
  ~ClothVisual();
  ClothVisual(const ClothVisual&) = delete;
  ClothVisual& operator=(const ClothVisual&) = delete;

  void set_topology(const clothsim::ClothTopology&);

  /// Draws a state that fits the topology. `colors` of the surface, with opacity: one for each
  /// point or one for all.
  void set_state(const clothsim::ClothState&, const std::vector<float>& normals,
                 const std::vector<Rgba>& colors);

  /// An image that multiplies the colours, by the points' uv; null: none.
  void set_image(const Ogre::TexturePtr&);

  void show(Part part, bool wanted) { parts_[part].primitive->show(wanted); }

 private:
  struct Drawn {
    Ogre::MaterialPtr material;
    std::unique_ptr<Primitive> primitive;
  };

  void make_part(Part, Ogre::RenderOperation::OperationType, const Ogre::MaterialPtr&);
  void make_vertices(std::size_t count);

  Ogre::SceneNode* node_;
  std::unique_ptr<Ogre::VertexData> vertices_;
  std::array<Drawn, part_count> parts_;
  std::vector<std::uint32_t> held_;
  std::vector<float> uv_;  // v downwards, as images have their top row first
};

}  // namespace clothsim_rviz
