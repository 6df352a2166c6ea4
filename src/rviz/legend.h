#pragma once

#include <OgreMaterial.h>
#include <OgreTexture.h>

#include <string>

namespace Ogre {
class Overlay;
class OverlayContainer;
}  // namespace Ogre

namespace clothsim_rviz {

/// A bar with the colours of a quantity and its range, in the picture's upper left corner. Several
/// are stacked.
class Legend {
 public:
  Legend();
  ~Legend();
  Legend(const Legend&) = delete;
  Legend& operator=(const Legend&) = delete;

  /// `title` with its unit; `low` and `high`: the values at the ends of the bar.
  void show(const std::string& title, double low, double high);
  void hide();

 private:
  void paint(const std::string& title, const std::string& low, const std::string& high);

  int slot_;  // index from the top
  std::string painted_;
  Ogre::TexturePtr texture_;
  Ogre::MaterialPtr material_;
  Ogre::Overlay* overlay_;
  Ogre::OverlayContainer* panel_;
};

}  // namespace clothsim_rviz
