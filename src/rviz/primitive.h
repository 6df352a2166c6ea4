#pragma once

#include <OgreSimpleRenderable.h>

#include <cstdint>
#include <vector>

namespace clothsim_rviz {

/// Triangles, lines or points between vertices that belong to another, which must outlive this.
class Primitive : public Ogre::SimpleRenderable {
 public:
  Primitive(Ogre::RenderOperation::OperationType, const Ogre::MaterialPtr&);
  ~Primitive() override;

  /// All primitives on the same vertices are drawn from the same buffer.
  void set_vertices(Ogre::VertexData*);

  /// Three, two or one a primitive.
  void set_indices(const std::vector<std::uint32_t>&);

  /// Beside Ogre's own visibility, which RViz switches for all of a display.
  void show(bool wanted) { wanted_ = wanted; }

  Ogre::Real getSquaredViewDepth(const Ogre::Camera*) const override;
  Ogre::Real getBoundingRadius() const override;
  void _updateRenderQueue(Ogre::RenderQueue*) override;

 private:
  bool wanted_ = true;
};

}  // namespace clothsim_rviz
