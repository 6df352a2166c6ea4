#include "look_at.h"

#include <OgreCamera.h>
#include <rviz/properties/property.h>
#include <rviz/view_controller.h>

#include <cmath>

#include "stage.h"

namespace clothsim_rviz {

void look_at(rviz::ViewController& view, const Eigen::AlignedBox3d& box) {
  if (view.getClassId() != "rviz/Orbit") return;
  const double pitch = view.subProp("Pitch")->getValue().toDouble();
  const double yaw = view.subProp("Yaw")->getValue().toDouble();
  const clothsim::Vector3 out(std::cos(yaw) * std::cos(pitch), std::sin(yaw) * std::cos(pitch),
                              std::sin(pitch));
  const Ogre::Camera& camera = *view.getCamera();
  const double up = std::tan(camera.getFOVy().valueRadians() / 2);
  const Lens lens{up * camera.getAspectRatio(), up};

  rviz::Property& focus = *view.subProp("Focal Point");
  focus.subProp("X")->setValue(box.center().x());
  focus.subProp("Y")->setValue(box.center().y());
  focus.subProp("Z")->setValue(box.center().z());
  view.subProp("Distance")->setValue(viewing_distance(box, out, lens));
}

}  // namespace clothsim_rviz
