#include "cloth_visual.h"

#include <OgreHardwareBufferManager.h>
#include <OgreSceneNode.h>

#include <algorithm>

#include "clothsim/render/shading.h"
#include "materials.h"

namespace clothsim_rviz {
namespace {

struct Vertex {
  std::array<float, 3> position;  // [m]
  std::array<float, 3> normal;
  std::array<float, 2> uv;
  Rgba color;
};
static_assert(sizeof(Vertex) == 9 * sizeof(float), "as the buffer's declaration has it");

// Shift towards the camera, so that the surface hides lines only where it is in front [m].
constexpr double line_nearer = 0.001;
constexpr double point_nearer = 0.03;  // half a point's width, for slanted surfaces

const Ogre::ColourValue pin_color(0.20f, 0.75f, 0.35f);
const Ogre::ColourValue held_color(1.0f, 0.85f, 0.1f);

Ogre::ColourValue to_ogre(const clothsim::Color& color) {
  const Eigen::Vector3f c = color.cast<float>();
  return Ogre::ColourValue(c[0], c[1], c[2]);
}

template <std::size_t Size>
void copy_to(std::array<float, Size>& target, const std::vector<float>& flat, std::size_t index) {
  std::copy_n(flat.begin() + static_cast<std::ptrdiff_t>(Size * index), Size, target.begin());
}

/// The box around points in flat xyz.
Ogre::AxisAlignedBox box_about(const std::vector<float>& xyz) {
  Ogre::AxisAlignedBox box;
  for (std::size_t i = 0; i < xyz.size(); i += 3) {
    box.merge(Ogre::Vector3(xyz[i], xyz[i + 1], xyz[i + 2]));
  }
  return box;
}

}  // namespace

ClothVisual::ClothVisual(Ogre::SceneNode* node) : node_(node) {
  using Operation = Ogre::RenderOperation;
  const clothsim::Wireframe as_in_images;
  make_part(surface, Operation::OT_TRIANGLE_LIST, make_surface_material({}));
  for (std::size_t i = 0; i < as_in_images.colors.size(); ++i) {
    make_part(static_cast<Part>(structural + i), Operation::OT_LINE_LIST,
              make_flat_material(to_ogre(as_in_images.colors[i]), line_nearer));
  }
  make_part(pins, Operation::OT_POINT_LIST, make_flat_material(pin_color, point_nearer));
  make_part(held, Operation::OT_POINT_LIST, make_flat_material(held_color, point_nearer));
}

ClothVisual::~ClothVisual() {
  for (Drawn& part : parts_) {
    if (part.primitive->isAttached()) node_->detachObject(part.primitive.get());
    part.primitive.reset();
    remove(part.material);
  }
}

void ClothVisual::make_part(Part part, Ogre::RenderOperation::OperationType type,
                            const Ogre::MaterialPtr& material) {
  parts_[part] = {material, std::make_unique<Primitive>(type, material)};
}

void ClothVisual::make_vertices(std::size_t count) {
  auto vertices = std::make_unique<Ogre::VertexData>();
  vertices->vertexCount = count;
  Ogre::VertexDeclaration& layout = *vertices->vertexDeclaration;
  layout.addElement(0, offsetof(Vertex, position), Ogre::VET_FLOAT3, Ogre::VES_POSITION);
  layout.addElement(0, offsetof(Vertex, normal), Ogre::VET_FLOAT3, Ogre::VES_NORMAL);
  layout.addElement(0, offsetof(Vertex, uv), Ogre::VET_FLOAT2, Ogre::VES_TEXTURE_COORDINATES);
  layout.addElement(0, offsetof(Vertex, color), Ogre::VET_UBYTE4_NORM, Ogre::VES_DIFFUSE);
  vertices->vertexBufferBinding->setBinding(
      0, Ogre::HardwareBufferManager::getSingleton().createVertexBuffer(
             sizeof(Vertex), count, Ogre::HardwareBuffer::HBU_DYNAMIC_WRITE_ONLY_DISCARDABLE));
  for (Drawn& part : parts_) part.primitive->set_vertices(vertices.get());
  vertices_ = std::move(vertices);
}

void ClothVisual::set_topology(const clothsim::ClothTopology& topology) {
  const std::size_t count = topology.rest_positions.size() / 3;
  if (!vertices_ || vertices_->vertexCount != count) make_vertices(count);
  const std::array<const std::vector<std::uint32_t>*, part_count> indices = {
      &topology.triangles, &topology.structural, &topology.shear,
      &topology.bending,   &topology.pinned,     &held_};
  held_.clear();
  uv_ = topology.uv;
  for (std::size_t i = 1; i < uv_.size(); i += 2) uv_[i] = 1 - uv_[i];
  for (std::size_t i = 0; i < parts_.size(); ++i) parts_[i].primitive->set_indices(*indices[i]);
}

void ClothVisual::set_state(const clothsim::ClothState& state, const std::vector<float>& normals,
                            const std::vector<Rgba>& colors) {
  const Ogre::HardwareVertexBufferSharedPtr& buffer = vertices_->vertexBufferBinding->getBuffer(0);
  auto* vertex = static_cast<Vertex*>(buffer->lock(Ogre::HardwareBuffer::HBL_DISCARD));
  for (std::size_t i = 0; i < vertices_->vertexCount; ++i) {
    copy_to(vertex[i].position, state.positions, i);
    copy_to(vertex[i].normal, normals, i);
    copy_to(vertex[i].uv, uv_, i);
    vertex[i].color = colors[colors.size() > 1 ? i : 0];
  }
  buffer->unlock();
  const bool opaque =
      std::all_of(colors.begin(), colors.end(), [](const Rgba& color) { return color[3] == 255; });
  set_opaque(*parts_[surface].material, opaque);
  if (held_ != state.held) {
    held_ = state.held;
    parts_[held].primitive->set_indices(held_);
  }
  const Ogre::AxisAlignedBox box = box_about(state.positions);
  for (Drawn& part : parts_) {
    part.primitive->setBoundingBox(box);
    if (!part.primitive->isAttached()) node_->attachObject(part.primitive.get());
  }
  node_->needUpdate();  // the box has changed
}

void ClothVisual::set_image(const Ogre::TexturePtr& image) {
  Drawn& part = parts_[surface];
  Ogre::MaterialPtr other = make_surface_material(image);
  part.primitive->setMaterial(other);
  std::swap(part.material, other);
  remove(other);
}

}  // namespace clothsim_rviz
