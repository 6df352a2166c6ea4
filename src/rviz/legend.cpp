#include "legend.h"

#include <OgreHardwarePixelBuffer.h>
#include <OgreMaterialManager.h>
#include <OgrePass.h>
#include <OgreTechnique.h>
#include <OgreTextureManager.h>
#include <Overlay/OgreOverlay.h>
#include <Overlay/OgreOverlayContainer.h>
#include <Overlay/OgreOverlayManager.h>

#include <QImage>
#include <QPainter>
#include <cstdio>
#include <set>

#include "color_map.h"
#include "materials.h"

namespace clothsim_rviz {
namespace {

constexpr int width = 240, height = 46;  // [pixel]
constexpr int margin = 8;  // of the text and the bar within, and to the picture's edge
constexpr int bar_top = 20, bar_height = 8;

std::set<int>& taken_slots() {
  static std::set<int> slots;
  return slots;
}

int take_slot() {
  int slot = 0;
  while (!taken_slots().insert(slot).second) ++slot;
  return slot;
}

std::string to_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

QImage bar() {
  const auto colors = color_map();
  return QImage(colors.data(), color_map_size, 1, QImage::Format_RGB888).copy();
}

Ogre::TexturePtr make_canvas() {
  return Ogre::TextureManager::getSingleton().createManual(
      new_name("legend"), Ogre::ResourceGroupManager::DEFAULT_RESOURCE_GROUP_NAME,
      Ogre::TEX_TYPE_2D, width, height, 0, Ogre::PF_BYTE_BGRA);
}

Ogre::MaterialPtr make_material(const Ogre::TexturePtr& texture) {
  const Ogre::MaterialPtr material = Ogre::MaterialManager::getSingleton().create(
      new_name("legend"), Ogre::ResourceGroupManager::DEFAULT_RESOURCE_GROUP_NAME);
  Ogre::Pass& pass = *material->getTechnique(0)->getPass(0);
  pass.setLightingEnabled(false);
  pass.setSceneBlending(Ogre::SBT_TRANSPARENT_ALPHA);
  pass.setDepthCheckEnabled(false);
  pass.setDepthWriteEnabled(false);
  pass.createTextureUnitState()->setTexture(texture);
  return material;
}

}  // namespace

Legend::Legend() : slot_(take_slot()), texture_(make_canvas()), material_(make_material(texture_)) {
  Ogre::OverlayManager& overlays = Ogre::OverlayManager::getSingleton();
  overlay_ = overlays.create(new_name("legend"));
  panel_ = static_cast<Ogre::OverlayContainer*>(
      overlays.createOverlayElement("Panel", new_name("legend")));
  panel_->setMetricsMode(Ogre::GMM_PIXELS);
  panel_->setPosition(margin, static_cast<float>(margin + slot_ * (height + margin)));
  panel_->setDimensions(width, height);
  panel_->setMaterial(material_);
  overlay_->add2D(panel_);
}

Legend::~Legend() {
  Ogre::OverlayManager& overlays = Ogre::OverlayManager::getSingleton();
  overlays.destroy(overlay_);
  overlays.destroyOverlayElement(panel_);
  remove(material_);
  remove(texture_);
  taken_slots().erase(slot_);
}

void Legend::show(const std::string& title, double low, double high) {
  paint(title, to_text(low), to_text(high));
  overlay_->show();
}

void Legend::hide() { overlay_->hide(); }

void Legend::paint(const std::string& title, const std::string& low, const std::string& high) {
  const std::string text = title + "\n" + low + "\n" + high;
  if (text == painted_) return;
  painted_ = text;

  QImage image(width, height, QImage::Format_ARGB32);
  image.fill(QColor(0, 0, 0, 110));
  QPainter painter(&image);
  painter.setPen(Qt::white);
  QFont font = painter.font();
  font.setPixelSize(11);
  painter.setFont(font);
  const QRect inside = image.rect().adjusted(margin, 3, -margin, -2);
  painter.drawText(inside, Qt::AlignTop | Qt::AlignHCenter, QString::fromStdString(title));
  painter.drawImage(QRect(margin, bar_top, width - 2 * margin, bar_height), bar());
  painter.drawText(inside, Qt::AlignBottom | Qt::AlignLeft, QString::fromStdString(low));
  painter.drawText(inside, Qt::AlignBottom | Qt::AlignRight, QString::fromStdString(high));
  painter.end();
  texture_->getBuffer()->blitFromMemory(
      Ogre::PixelBox(width, height, 1, Ogre::PF_BYTE_BGRA, image.bits()));
}

}  // namespace clothsim_rviz
