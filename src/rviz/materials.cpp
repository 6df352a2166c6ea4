#include "materials.h"

#include <OgreHardwarePixelBuffer.h>
#include <OgreHighLevelGpuProgram.h>
#include <OgreHighLevelGpuProgramManager.h>
#include <OgreMaterialManager.h>
#include <OgrePass.h>
#include <OgreResourceGroupManager.h>
#include <OgreTechnique.h>
#include <OgreTextureManager.h>
#include <OgreTextureUnitState.h>

#include <fstream>
#include <iterator>
#include <stdexcept>

#include "clothsim/model/package.h"

namespace clothsim_rviz {
namespace {

constexpr double surface_lift = 0.0005;  // [m] the same as in ~markers, for each side
constexpr float point_size = 8;          // [pixel]

const Ogre::String& group() { return Ogre::ResourceGroupManager::DEFAULT_RESOURCE_GROUP_NAME; }

std::string read_shader(const std::string& name) {
  const std::string path = clothsim::package_folder("shaders") + "/rviz/" + name;
  std::ifstream file(path);
  std::string text(std::istreambuf_iterator<char>(file), {});
  if (!file || text.empty()) throw std::runtime_error("cannot read " + path);
  return text;
}

/// The program of a file, compiled once per process.
std::string program(const std::string& file, Ogre::GpuProgramType type) {
  auto& manager = Ogre::HighLevelGpuProgramManager::getSingleton();
  const std::string name = "clothsim/" + file;
  if (!manager.resourceExists(name, group())) {
    manager.createProgram(name, group(), "glsl", type)->setSource(read_shader(file));
  }
  return name;
}

/// A pass that draws both sides, shifted towards the camera [m].
Ogre::Pass& make_pass(const Ogre::MaterialPtr& material, const std::string& fragments,
                      double nearer) {
  Ogre::Pass& pass = *material->getTechnique(0)->getPass(0);
  pass.setCullingMode(Ogre::CULL_NONE);
  pass.setVertexProgram(program("cloth.vert", Ogre::GPT_VERTEX_PROGRAM));
  pass.setFragmentProgram(program(fragments, Ogre::GPT_FRAGMENT_PROGRAM));
  using Parameters = Ogre::GpuProgramParameters;
  const auto vertex = pass.getVertexProgramParameters();
  vertex->setNamedAutoConstant("world_view", Parameters::ACT_WORLDVIEW_MATRIX);
  vertex->setNamedAutoConstant("projection", Parameters::ACT_PROJECTION_MATRIX);
  vertex->setNamedAutoConstant("normal_matrix", Parameters::ACT_INVERSE_TRANSPOSE_WORLDVIEW_MATRIX);
  vertex->setNamedConstant("lift", static_cast<float>(surface_lift));
  vertex->setNamedConstant("nearer", static_cast<float>(nearer));
  vertex->setNamedAutoConstant("ambient", Parameters::ACT_AMBIENT_LIGHT_COLOUR);
  vertex->setNamedAutoConstant("lamp_color", Parameters::ACT_LIGHT_DIFFUSE_COLOUR, 0);
  vertex->setNamedAutoConstant("lamp_place", Parameters::ACT_LIGHT_POSITION_VIEW_SPACE, 0);
  return pass;
}

Ogre::MaterialPtr make_material(const std::string& kind) {
  return Ogre::MaterialManager::getSingleton().create(new_name(kind), group());
}

}  // namespace

std::string new_name(const std::string& kind) {
  static int count = 0;  // used in RViz's one thread
  return "clothsim/" + kind + std::to_string(count++);
}

Ogre::MaterialPtr make_surface_material(const Ogre::TexturePtr& image) {
  const Ogre::MaterialPtr material = make_material("surface");
  Ogre::Pass& pass = make_pass(material, image ? "texture.frag" : "cloth.frag", 0);
  if (image) {
    Ogre::TextureUnitState& unit = *pass.createTextureUnitState();
    unit.setTexture(image);
    unit.setTextureAddressingMode(Ogre::TAM_CLAMP);
  }
  return material;
}

Ogre::MaterialPtr make_flat_material(const Ogre::ColourValue& color, double nearer) {
  const Ogre::MaterialPtr material = make_material("flat");
  Ogre::Pass& pass = make_pass(material, "flat.frag", nearer);
  pass.setPointSize(point_size);
  pass.getFragmentProgramParameters()->setNamedConstant("surface_color", color);
  return material;
}

void set_opaque(Ogre::Material& material, bool opaque) {
  Ogre::Pass& pass = *material.getTechnique(0)->getPass(0);
  pass.setSceneBlending(opaque ? Ogre::SBT_REPLACE : Ogre::SBT_TRANSPARENT_ALPHA);
  pass.setDepthWriteEnabled(opaque);
}

Ogre::TexturePtr make_texture(const clothsim::Image& image) {
  const auto width = static_cast<Ogre::uint32>(image.width);
  const auto height = static_cast<Ogre::uint32>(image.height);
  const Ogre::TexturePtr texture = Ogre::TextureManager::getSingleton().createManual(
      new_name("texture"), group(), Ogre::TEX_TYPE_2D, width, height, Ogre::MIP_DEFAULT,
      Ogre::PF_BYTE_RGB, Ogre::TU_DEFAULT | Ogre::TU_AUTOMIPMAP);
  // Ogre only reads from it.
  texture->getBuffer()->blitFromMemory(Ogre::PixelBox(width, height, 1, Ogre::PF_BYTE_RGB,
                                                      const_cast<std::uint8_t*>(image.rgb.data())));
  return texture;
}

void remove(Ogre::MaterialPtr& material) {
  if (material) Ogre::MaterialManager::getSingleton().remove(material);
  material.reset();
}

void remove(Ogre::TexturePtr& texture) {
  if (texture) Ogre::TextureManager::getSingleton().remove(texture);
  texture.reset();
}

}  // namespace clothsim_rviz
