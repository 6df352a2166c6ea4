#pragma once

#include <map>
#include <optional>
#include <string>

#include "clothsim/render/camera.h"
#include "clothsim/render/snapshot.h"
#include "clothsim/scene/scene.h"
#include "clothsim/view/look.h"

namespace clothsim {

/// The look of a collider, and the resolution of its mesh.
struct ColliderLook {
  Look look;
  int segments = 64;
  double extent = 10;  // [m] side length of a plane

  ColliderLook() { look.color = {0.35, 0.45, 0.6}; }
};

/// All settings of a picture of a scene, apart from the scene.
struct View {
  Camera camera;                   // without a pose: eye and target give it
  Vector3 eye{2, -1.8, 1.4};       // [m] from here each of config/scenes is in the picture
  Vector3 target{0.5, 0.15, 0.4};  // [m]
  std::string frame;               // tf frame of the camera once tf has it, in optical convention
  Light light;
  Color background{0.1, 0.1, 0.12};
  std::string sky;                                // as Look::environment; empty: the colour
  Look cloth;                                     // for cloths that are not named
  std::map<std::string, Look> cloths;             // of several, by name
  ColliderLook collider;                          // for colliders that are not named
  std::map<std::string, ColliderLook> colliders;  // by name
  double rate = 30;                               // [Hz] of pictures, at most
  bool each_step = true;                          // also a picture of the last frame of each ~step
  int samples = 4;                // per pixel of the colour image, for smooth edges; 1: none
  std::optional<int> egl_device;  // index of the EGL device; empty: the best
};

/// Throws InvalidValue for the look of a cloth or a collider that the scene does not have.
void check_names(const View&, const Scene&);

/// A view without the looks of cloths and colliders that the scene does not have.
View without_missing_names(View, const Scene&);

/// A view ready for drawing: images read, values checked.
struct PreparedView {
  Camera camera;
  Light light;
  Background background;
  Shading cloth;
  std::map<std::string, Shading> cloths;
  ColliderView collider;  // shape and pose are set for each picture
  std::map<std::string, ColliderView> colliders;
};

/// Throws InvalidValue with a key such as {"colliders", "sphere", "texture"}.
PreparedView prepare(const View&, ImageStore&);

}  // namespace clothsim
