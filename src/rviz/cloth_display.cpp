#include "cloth_display.h"

#include <OgreSceneNode.h>
#include <rviz/display_context.h>
#include <rviz/frame_manager.h>
#include <rviz/properties/bool_property.h>
#include <rviz/properties/color_property.h>
#include <rviz/properties/enum_property.h>
#include <rviz/properties/float_property.h>
#include <rviz/properties/ros_topic_property.h>
#include <rviz/properties/string_property.h>
#include <rviz/view_manager.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <pluginlib/class_list_macros.hpp>

#include "clothsim/model/checks.h"
#include "clothsim/ros/markers.h"
#include "clothsim/ros/scene_parameter.h"
#include "clothsim/view/resources.h"
#include "look_at.h"
#include "materials.h"
#include "stage.h"

namespace clothsim_rviz {
namespace {

using rviz::StatusProperty;

/// Messages for display need no queue.
constexpr std::uint32_t queue_size = 1;

constexpr const char* state_ending = "/state";

struct QuantityRow {
  Quantity quantity;
  const char* title;
};
constexpr QuantityRow quantity_rows[] = {{Quantity::stretch, "stretch [-]"},
                                         {Quantity::speed, "speed [m/s]"},
                                         {Quantity::height, "height [m]"}};

/// The node that publishes a topic of states; empty: it is none.
std::string node_of(const std::string& topic) {
  const std::string ending = state_ending;
  const bool fits = topic.size() > ending.size() &&
                    topic.compare(topic.size() - ending.size(), ending.size(), ending) == 0;
  return fits ? topic.substr(0, topic.size() - ending.size()) : "";
}

/// The value clamped to [0, 1]; 0 for NaN, which a property may hold.
float to_share(float value) { return std::min(1.0f, std::max(0.0f, value)); }

clothsim::Pose to_pose(const Ogre::Vector3& p, const Ogre::Quaternion& r) {
  return {{p.x, p.y, p.z}, Eigen::Quaterniond(r.w, r.x, r.y, r.z)};
}

}  // namespace

ClothDisplay::ClothDisplay() : color_map_(color_map()), images_(clothsim::textures_folder()) {
  topic_ = new rviz::RosTopicProperty(
      "State Topic", "clothsim/state",
      QString::fromStdString(ros::message_traits::datatype<clothsim::ClothState>()),
      "~state of a clothsim node; its ~topology is looked for beside it.", this,
      SLOT(resubscribe()));
  look_at_scenes_ = new rviz::BoolProperty("Look at New Scenes", false,
                                           "The camera turns to each scene that the node starts "
                                           "with or loads, all of it in the picture.",
                                           this);
  make_surface_properties();
  make_part_properties();
}

void ClothDisplay::make_surface_properties() {
  coloring_ = new rviz::EnumProperty("Coloring", "Color", "Quantity that colours the surface.",
                                     this, SLOT(restyle()));
  coloring_->addOption("Color", color);
  coloring_->addOption("Texture", texture);
  coloring_->addOption("Stretch", stretch);
  coloring_->addOption("Speed", speed);
  coloring_->addOption("Height", height);
  color_ = new rviz::ColorProperty("Color", QColor(217, 84, 64),
                                   "Colour of the surface; of several cloths, of the first.", this,
                                   SLOT(restyle()));
  alpha_ = new rviz::FloatProperty("Alpha", 1, "Opacity, from 0 to 1.", this, SLOT(restyle()));
  alpha_->setMin(0);
  alpha_->setMax(1);
  texture_file_ = new rviz::StringProperty("Texture", "fabric.png",
                                           "Image file, or the name of one of the package's.", this,
                                           SLOT(reload_texture()));
  own_range_ = new rviz::BoolProperty(
      "Autocompute Range", true, "Colours span the values that are there.", this, SLOT(restyle()));
  low_ = new rviz::FloatProperty("Low", 0, "Value of the first colour.", this, SLOT(restyle()));
  high_ = new rviz::FloatProperty("High", 0.1f, "Value of the last colour.", this, SLOT(restyle()));
  show_legend_ = new rviz::BoolProperty("Legend", true, "Of the colours of a quantity.", this,
                                        SLOT(restyle()));
}

void ClothDisplay::make_part_properties() {
  const auto add = [this](ClothVisual::Part part, const char* name, bool shown, const char* what) {
    show_[part] = new rviz::BoolProperty(name, shown, what, this, SLOT(restyle()));
  };
  add(ClothVisual::surface, "Surface", true, "The cloth, both sides.");
  add(ClothVisual::structural, "Structural Springs", false, "To the left and upper neighbour.");
  add(ClothVisual::shear, "Shear Springs", false, "To the diagonal neighbours.");
  add(ClothVisual::bending, "Bending Springs", false, "To the second neighbours.");
  add(ClothVisual::pins, "Pins", true, "Of the scene, green.");
  add(ClothVisual::held, "Held Points", true, "By ~attach, yellow.");
}

ClothDisplay::~ClothDisplay() {
  unsubscribe();
  visual_.reset();
  remove(texture_);
}

void ClothDisplay::onInitialize() {
  try {
    visual_ = std::make_unique<ClothVisual>(scene_node_);
    legend_ = std::make_unique<Legend>();
    legend_->hide();
  } catch (const std::exception& error) {  // Ogre's, too: an error in a display must not end RViz
    visual_.reset();
    tell(StatusProperty::Error, "OpenGL", error.what());
    return;
  }
  restyle();
}

void ClothDisplay::onEnable() {
  subscribe();
  restyle();
}

void ClothDisplay::onDisable() {
  unsubscribe();
  if (legend_) legend_->hide();
}

void ClothDisplay::setTopic(const QString& topic, const QString&) { topic_->setString(topic); }

void ClothDisplay::reset() {
  Display::reset();
  told_.clear();
  resubscribe();
}

void ClothDisplay::resubscribe() {
  unsubscribe();
  if (isEnabled()) subscribe();
}

void ClothDisplay::subscribe() {
  const std::string node = node_of(topic_->getTopicStd());
  if (node.empty()) {
    tell(StatusProperty::Error, "Topic", "expected the ~state of a clothsim node");
    return;
  }
  try {
    topology_subscriber_ = update_nh_.subscribe<clothsim::ClothTopology>(
        node + "/topology", queue_size, [this](const clothsim::ClothTopology::ConstPtr& topology) {
          newest_topology_ = topology;
          topology_is_sound_ = false;
          drawn_ = false;
        });
    state_subscriber_ = update_nh_.subscribe<clothsim::ClothState>(
        node + state_ending, queue_size, [this](const clothsim::ClothState::ConstPtr& state) {
          newest_state_ = state;
          drawn_ = false;
        });
  } catch (const ros::Exception& error) {
    tell(StatusProperty::Error, "Topic", error.what());
  }
}

void ClothDisplay::unsubscribe() {
  topology_subscriber_.shutdown();
  state_subscriber_.shutdown();
  newest_topology_.reset();
  newest_state_.reset();
  topology_.reset();
  state_.reset();
  if (scene_node_) scene_node_->setVisible(false);
}

void ClothDisplay::restyle() {
  const bool quantity = is_quantity();
  color_->setHidden(coloring() != color);
  texture_file_->setHidden(coloring() != texture);
  own_range_->setHidden(!quantity);
  show_legend_->setHidden(!quantity);
  low_->setHidden(!quantity || own_range_->getBool());
  high_->setHidden(!quantity || own_range_->getBool());
  drawn_ = false;
  if (!visual_) return;
  reload_texture();
  show_parts();
  if (!quantity || !show_legend_->getBool()) legend_->hide();
}

void ClothDisplay::show_parts() {
  for (const auto& [part, property] : show_) visual_->show(part, property->getBool());
  // A rope has no surface.
  if (topology_ && topology_->triangles.empty()) visual_->show(ClothVisual::structural, true);
}

void ClothDisplay::reload_texture() {
  if (!visual_) return;
  std::shared_ptr<const clothsim::Image> image;
  if (coloring() == texture) {
    try {
      image = images_.image(texture_file_->getStdString(), "Texture");
      tell(StatusProperty::Ok, "Texture", "there");
    } catch (const std::exception& error) {
      tell(StatusProperty::Error, "Texture", error.what());
    }
  }
  if (image == image_) return;
  image_ = image;
  Ogre::TexturePtr other = image ? make_texture(*image) : Ogre::TexturePtr();
  visual_->set_image(other);
  std::swap(texture_, other);
  remove(other);
  drawn_ = false;
}

void ClothDisplay::update(float, float) {
  if (!visual_) return;
  tell_publisher();
  take();
  const bool placed = state_ && place_frame();
  scene_node_->setVisible(placed);
  if (!placed || drawn_) return;
  draw();
  drawn_ = true;
  look_at_scene();
  context_->queueRender();
}

void ClothDisplay::look_at_scene() {
  // Topologies of the same cloth come when springs are switched, too.
  if (!look_at_scenes_->getBool() || topology_->rest_positions == looked_at_) return;
  looked_at_ = topology_->rest_positions;
  calls_.post([this, node = node_of(state_subscriber_.getTopic()),
               in_fixed = in_fixed_]() -> CallQueue::Answer {
    std::optional<clothsim::Scene> scene;
    try {
      scene = clothsim_ros::read_scene_parameter(ros::NodeHandle(node)).scene;
    } catch (const clothsim::InvalidValue&) {  // the node reports it
      return [] {};
    }
    return [this, stage = stage_of(*scene, in_fixed)] {
      look_at(*context_->getViewManager()->getCurrent(), stage);
    };
  });
}

void ClothDisplay::tell_publisher() {
  const bool there = state_subscriber_ && state_subscriber_.getNumPublishers() > 0;
  const bool topology = topology_subscriber_ && topology_subscriber_.getNumPublishers() > 0;
  if (!state_subscriber_) return;  // reported by subscribe()
  tell(there && topology ? StatusProperty::Ok : StatusProperty::Warn, "Topic",
       !there     ? "nobody publishes " + state_subscriber_.getTopic()
       : topology ? "there"
                  : "nobody publishes " + topology_subscriber_.getTopic());
}

void ClothDisplay::take() {
  if (drawn_) return;
  if (!newest_topology_ || !newest_state_) {
    tell(StatusProperty::Warn, "Cloth", newest_topology_ ? "no state yet" : "no topology yet");
    return;
  }
  try {
    if (!topology_is_sound_) {
      clothsim::inside("topology", [this] { check_topology(*newest_topology_); });
      topology_is_sound_ = true;
    }
    clothsim::inside("state", [this] { check_state(*newest_state_, *newest_topology_); });
  } catch (const clothsim::InvalidValue& error) {
    tell(StatusProperty::Error, "Cloth", error.what());
    return;
  }
  if (topology_ != newest_topology_) {
    topology_ = newest_topology_;
    visual_->set_topology(*topology_);
    show_parts();
  }
  state_ = newest_state_;
  tell(StatusProperty::Ok, "Cloth",
       std::to_string(topology_->columns) + " x " + std::to_string(topology_->rows) + " points");
}

bool ClothDisplay::place_frame() {
  Ogre::Vector3 position;
  Ogre::Quaternion rotation;
  const std::string& frame = state_->header.frame_id;
  // The latest one: tf comes a little after the states.
  if (!context_->getFrameManager()->getTransform(frame, ros::Time(), position, rotation)) {
    tell(StatusProperty::Error, "Transform",
         "no transform from \"" + frame + "\" to \"" + fixed_frame_.toStdString() + '"');
    return false;
  }
  tell(StatusProperty::Ok, "Transform", "there");
  scene_node_->setPosition(position);
  scene_node_->setOrientation(rotation);
  in_fixed_ = to_pose(position, rotation);
  return true;
}

void ClothDisplay::draw() {
  find_normals(state_->positions, topology_->triangles, normals_);
  visual_->set_state(*state_, normals_, colors());
}

std::vector<Rgba> ClothDisplay::colors() {
  const auto opacity = static_cast<std::uint8_t>(std::lround(255 * to_share(alpha_->getFloat())));
  if (is_quantity()) return colors_of_quantity(opacity);
  if (texture_) return {{255, 255, 255, opacity}};
  const QColor shade = color_->getColor();
  const auto byte = [](int value) { return static_cast<std::uint8_t>(value); };
  const Rgba own{byte(shade.red()), byte(shade.green()), byte(shade.blue()), opacity};
  const std::vector<std::uint32_t>& firsts = topology_->first_points;
  if (firsts.size() < 2) return {own};
  std::vector<Rgba> colors(state_->positions.size() / 3, own);
  for (std::size_t cloth = 1; cloth < firsts.size(); ++cloth) {  // up to the last point
    Rgba rgba{0, 0, 0, opacity};
    const auto shares = clothsim_ros::cloth_color(cloth);
    std::transform(shares.begin(), shares.end(), rgba.begin(),
                   [](float share) { return static_cast<std::uint8_t>(std::lround(255 * share)); });
    std::fill(colors.begin() + firsts[cloth], colors.end(), rgba);
  }
  return colors;
}

std::vector<Rgba> ClothDisplay::colors_of_quantity(std::uint8_t opacity) {
  const QuantityRow& row = quantity_rows[coloring() - stretch];
  const std::vector<float> values = values_of(row.quantity, *state_, *topology_);
  float low = low_->getFloat(), high = high_->getFloat();
  if (own_range_->getBool()) {
    const auto [least, most] = std::minmax_element(values.begin(), values.end());
    low = *least;
    high = *most;
  }
  if (show_legend_->getBool()) legend_->show(row.title, low, high);

  const float span = high != low ? high - low : 1;
  std::vector<Rgba> colors(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    const float t = to_share((values[i] - low) / span);
    const auto place = static_cast<std::size_t>(std::lround(t * (color_map_size - 1)));
    const std::uint8_t* rgb = &color_map_[3 * place];
    colors[i] = {rgb[0], rgb[1], rgb[2], opacity};
  }
  return colors;
}

std::optional<ClothDisplay::Shown> ClothDisplay::shown() const {
  if (!isEnabled() || !state_ || !drawn_) return {};
  return Shown{node_of(state_subscriber_.getTopic()), state_->header.frame_id, in_fixed_, topology_,
               state_};
}

void ClothDisplay::tell(StatusProperty::Level level, const std::string& name,
                        const std::string& text) {
  auto& told = told_[name];
  if (told == std::make_pair(static_cast<int>(level), text)) return;
  told = {level, text};
  setStatusStd(level, name, text);
}

bool ClothDisplay::is_quantity() const { return coloring() != color && coloring() != texture; }

ClothDisplay::Coloring ClothDisplay::coloring() const {
  return static_cast<Coloring>(coloring_->getOptionInt());
}

}  // namespace clothsim_rviz

PLUGINLIB_EXPORT_CLASS(clothsim_rviz::ClothDisplay, rviz::Display)
