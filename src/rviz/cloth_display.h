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

/// Draws the cloth of one clothsim node, from its ~state and ~topology. Errors are shown in the
/// display's status, and the last drawing stays.
class ClothDisplay : public rviz::Display {
  Q_OBJECT

 public:
  ClothDisplay();
  ~ClothDisplay() override;

  void reset() override;
  void update(float wall_dt, float ros_dt) override;
  void setTopic(const QString& topic, const QString& datatype) override;

  /// The drawn cloth, for tools that pick points of it.
  struct Shown {
    std::string node;         // its namespace, such as /clothsim
    std::string world_frame;  // of the positions
    clothsim::Pose in_fixed;  // world_frame in RViz's fixed frame
    clothsim::ClothTopology::ConstPtr topology;
    clothsim::ClothState::ConstPtr state;
  };
  /// Empty: nothing is drawn.
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
  /// Adopts the newest messages where they fit each other.
  void take();
  void draw();
  /// Colours of the surface, one for each point or one for all.
  std::vector<Rgba> colors();
  std::vector<Rgba> colors_of_quantity(std::uint8_t opacity);
  bool place_frame();
  /// Points RViz's camera at the node's scene, where it is a new one.
  void look_at_scene();
  void tell_publisher();
  /// Sets a status where it changes.
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
  clothsim::ClothTopology::ConstPtr topology_;  // of the drawing, checked, too
  clothsim::ClothState::ConstPtr state_;
  bool topology_is_sound_ = false;
  bool drawn_ = false;  // the newest state is drawn in the present style

  std::unique_ptr<ClothVisual> visual_;
  std::unique_ptr<Legend> legend_;
  Ogre::TexturePtr texture_;
  std::shared_ptr<const clothsim::Image> image_;  // of texture_
  const ColorMap color_map_;
  clothsim::ImageStore images_;
  std::vector<float> normals_;  // buffer
  clothsim::Pose in_fixed_;
  std::map<std::string, std::pair<int, std::string>> told_;
  std::vector<float> looked_at_;  // rest positions of the scene that the camera was pointed at
  CallQueue calls_;               // last, so that its calls end before the other members
};

}  // namespace clothsim_rviz
