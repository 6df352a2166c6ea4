#pragma once

#include <OgreSimpleRenderable.h>

#include <cstdint>
#include <vector>

namespace clothsim_rviz {

/// Triangles, lines or points between vertices of another owner, which must outlive this.
class Primitive : public Ogre::SimpleRenderable {
 public:
  Primitive(Ogre::RenderOperation::OperationType, const Ogre::MaterialPtr&);
  ~Primitive() override;

  /// All primitives on the same vertices are drawn from the same buffer.
  void set_vertices(Ogre::VertexData*);

  /// Three, two or one index per primitive.
  void set_indices(const std::vector<std::uint32_t>&);

  /// In addition to Ogre's own visibility, which RViz switches for a whole display.
  void show(bool wanted) { wanted_ = wanted; }

  Ogre::Real getSquaredViewDepth(const Ogre::Camera*) const override;
  Ogre::Real getBoundingRadius() const override;
  void _updateRenderQueue(Ogre::RenderQueue*) override;

 private:
  bool wanted_ = true;
};

}  // namespace clothsim_rviz
