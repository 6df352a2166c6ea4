#include "primitive.h"

#include <OgreCamera.h>
#include <OgreHardwareBufferManager.h>
#include <OgreSceneNode.h>

namespace clothsim_rviz {

Primitive::Primitive(Ogre::RenderOperation::OperationType type, const Ogre::MaterialPtr& material) {
  mRenderOp.operationType = type;
  mRenderOp.useIndexes = true;
  mRenderOp.vertexData = nullptr;
  mRenderOp.indexData = new Ogre::IndexData;
  setMaterial(material);
}

Primitive::~Primitive() { delete mRenderOp.indexData; }

void Primitive::set_vertices(Ogre::VertexData* vertices) { mRenderOp.vertexData = vertices; }

void Primitive::set_indices(const std::vector<std::uint32_t>& indices) {
  Ogre::IndexData& data = *mRenderOp.indexData;
  data.indexStart = 0;
  data.indexCount = indices.size();
  data.indexBuffer.reset();
  if (!indices.empty()) {
    data.indexBuffer = Ogre::HardwareBufferManager::getSingleton().createIndexBuffer(
        Ogre::HardwareIndexBuffer::IT_32BIT, indices.size(),
        Ogre::HardwareBuffer::HBU_STATIC_WRITE_ONLY);
    data.indexBuffer->writeData(0, indices.size() * sizeof(std::uint32_t), indices.data(), true);
  }
}

Ogre::Real Primitive::getSquaredViewDepth(const Ogre::Camera* camera) const {
  const Ogre::Vector3 middle = getParentNode()->convertLocalToWorldPosition(mBox.getCenter());
  return (camera->getDerivedPosition() - middle).squaredLength();
}

Ogre::Real Primitive::getBoundingRadius() const { return Ogre::Math::boundingRadiusFromAABB(mBox); }

void Primitive::_updateRenderQueue(Ogre::RenderQueue* queue) {
  const bool is_empty = mRenderOp.indexData->indexCount == 0;
  if (wanted_ && !is_empty) Ogre::SimpleRenderable::_updateRenderQueue(queue);
}

}  // namespace clothsim_rviz
