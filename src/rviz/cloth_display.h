#pragma once

#include <clothsim/ClothState.h>
#include <clothsim/ClothTopology.h>
#include <rviz/display.h>

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "call_queue.h"
#include "cloth_mesh.h"
#include "cloth_visual.h"
#include "clothsim/shapes/collider.h"
#include "clothsim/view/image_store.h"
#include "color_map.h"
#include "legend.h"

namespace rviz {
class BoolProperty;
class ColorProperty;
class EnumProperty;
class FloatProperty;
class RosTopicProperty;
class StringProperty;
}  // namespace rviz

namespace clothsim_rviz {

/// Draws the cloth of one clothsim node, from its ~state and ~topology. What cannot be drawn is
/// told in the display's status, and what was drawn last stays.
class ClothDisplay : public rviz::Display {
  Q_OBJECT

 public:
  ClothDisplay();
  ~ClothDisplay() override;

  void reset() override;
  void update(float wall_dt, float ros_dt) override;
  void setTopic(const QString& topic, const QString& datatype) override;

  /// What is drawn, for who wants to point at it.
  struct Shown {
    std::string node;         // its namespace, such as /clothsim
    std::string world_frame;  // of the positions
    clothsim::Pose in_fixed;  // world_frame in RViz's fixed frame
    clothsim::ClothTopology::ConstPtr topology;
    clothsim::ClothState::ConstPtr state;
  };
  /// Empty: nothing is.
  std::optional<Shown> shown() const;

 protected:
  void onInitialize() override;
  void onEnable() override;
  void onDisable() override;

 private Q_SLOTS:
  void resubscribe();
  void restyle();
  void reload_texture();

 private:
  enum Coloring { color, texture, stretch, speed, height };

  void make_surface_properties();
  void make_part_properties();
  void show_parts();
  void subscribe();
  void unsubscribe();
  /// Takes up the newest messages where they fit each other.
  void take();
  void draw();
  /// Of the surface, one a point or one for all.
  std::vector<Rgba> colors();
  std::vector<Rgba> colors_of_quantity(std::uint8_t opacity);
  bool place_frame();
  /// Turns RViz's camera to the scene that the node has, where that is another than before.
  void look_at_scene();
  void tell_publisher();
  /// Sets a status where it is another than before.
  void tell(rviz::StatusProperty::Level, const std::string& name, const std::string& text);
  Coloring coloring() const;
  bool is_quantity() const;

  rviz::RosTopicProperty* topic_;
  rviz::EnumProperty* coloring_;
  rviz::ColorProperty* color_;
  rviz::FloatProperty* alpha_;
  rviz::StringProperty* texture_file_;
  rviz::BoolProperty* own_range_;
  rviz::FloatProperty* low_;
  rviz::FloatProperty* high_;
  rviz::BoolProperty* show_legend_;
  rviz::BoolProperty* look_at_scenes_;
  std::map<ClothVisual::Part, rviz::BoolProperty*> show_;

  ros::Subscriber topology_subscriber_;
  ros::Subscriber state_subscriber_;
  clothsim::ClothTopology::ConstPtr newest_topology_;
  clothsim::ClothState::ConstPtr newest_state_;
  clothsim::ClothTopology::ConstPtr topology_;  // that is drawn, likewise checked
  clothsim::ClothState::ConstPtr state_;
  bool topology_is_sound_ = false;
  bool drawn_ = false;  // the newest state, in the present style

  std::unique_ptr<ClothVisual> visual_;
  std::unique_ptr<Legend> legend_;
  Ogre::TexturePtr texture_;
  std::shared_ptr<const clothsim::Image> image_;  // of texture_
  const ColorMap color_map_;
  clothsim::ImageStore images_;
  std::vector<float> normals_;  // scratch
  clothsim::Pose in_fixed_;
  std::map<std::string, std::pair<int, std::string>> told_;
  std::vector<float> looked_at_;  // rest positions of the scene that the camera was turned to
  CallQueue calls_;               // last: what it runs is over before the rest goes
};

}  // namespace clothsim_rviz
