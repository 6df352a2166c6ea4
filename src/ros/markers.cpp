#include "clothsim/ros/markers.h"

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "clothsim/model/surface.h"
#include "clothsim/render/shading.h"
#include "clothsim/render/shape_drawing.h"
#include "clothsim/ros/conversions.h"

namespace clothsim_ros {
namespace {

using visualization_msgs::Marker;

/// Distance of a drawn side from the cloth [m]: the two sides must not flicker, and a collider must
/// not show through where the cloth spans its curve between two points.
constexpr double skin = 0.0005;

constexpr double line_width = 0.001;   // [m]
constexpr double pin_diameter = 0.02;  // [m]

std_msgs::ColorRGBA color(float r, float g, float b) {
  std_msgs::ColorRGBA msg;
  msg.r = r;
  msg.g = g;
  msg.b = b;
  msg.a = 1;
  return msg;
}

std_msgs::ColorRGBA color(const Eigen::Vector3f& rgb) { return color(rgb[0], rgb[1], rgb[2]); }

Marker make_marker(const std_msgs::Header& header, const std::string& ns, int id, int type,
                   const std_msgs::ColorRGBA& color) {
  Marker marker;
  marker.header = header;
  marker.ns = ns;
  marker.id = id;
  marker.type = type;
  marker.action = Marker::ADD;
  marker.pose.orientation.w = 1;
  marker.color = color;
  return marker;
}

void set_scale(Marker& marker, double x, double y, double z) {
  marker.scale.x = x;
  marker.scale.y = y;
  marker.scale.z = z;
}

/// Both sides of cloth `number`, as RViz lights the front of a triangle only: first all fronts,
/// then all backs. One colour for all, as colours per vertex would switch the lighting off.
Marker make_surface(const clothsim::Cloth& cloth, std::size_t number, const clothsim::Points& front,
                    const clothsim::Points& back, const std_msgs::Header& header) {
  const auto [r, g, b] = cloth_color(number);
  Marker marker = make_marker(header, "surface", static_cast<int>(number), Marker::TRIANGLE_LIST,
                              color(r, g, b));
  set_scale(marker, 1, 1, 1);
  const std::vector<int>& firsts = cloth.first_triangles;
  const auto all = static_cast<int>(cloth.triangles.size());
  const int first = firsts.empty() ? 0 : firsts[number];
  const int end = number + 1 < firsts.size() ? firsts[number + 1] : all;
  marker.points.reserve(6 * static_cast<std::size_t>(end - first));
  const auto add = [&](const clothsim::Points& positions, bool turned) {
    for (int t = first; t < end; ++t) {
      const auto& [i, j, k] = cloth.triangles[static_cast<std::size_t>(t)];
      for (const int point : {i, turned ? k : j, turned ? j : k}) {
        marker.points.push_back(to_point_msg(positions, point));
      }
    }
  };
  add(front, false);
  add(back, true);
  if (marker.points.empty()) marker.action = Marker::DELETE;
  return marker;
}

void add_surfaces(const clothsim::Cloth& cloth, const clothsim::Points& positions,
                  const std_msgs::Header& header, std::vector<Marker>& markers) {
  const clothsim::Points out = skin * clothsim::vertex_normals(positions, cloth.triangles);
  const clothsim::Points front = positions + out, back = positions - out;
  const std::size_t cloths = std::max<std::size_t>(cloth.first_triangles.size(), 1);
  for (std::size_t i = 0; i < cloths; ++i) {
    markers.push_back(make_surface(cloth, i, front, back, header));
  }
}

/// Springs of all families; a family without springs is deleted.
std::vector<Marker> make_springs(const clothsim::Cloth& cloth, const clothsim::Points& positions,
                                 const std_msgs::Header& header) {
  const clothsim::Wireframe as_in_images;

  std::vector<Marker> markers(as_in_images.colors.size());
  for (size_t i = 0; i < markers.size(); ++i) {
    markers[i] = make_marker(header, clothsim::spring_family_names[i], 0, Marker::LINE_LIST,
                             color(as_in_images.colors[i].cast<float>()));
    markers[i].scale.x = line_width;
  }
  for (const clothsim::SpringRun& run : cloth.springs) {
    auto& points = markers[static_cast<size_t>(run.family)].points;
    for (int point = run.first; point < run.first + run.count; ++point) {
      points.push_back(to_point_msg(positions, point));
      points.push_back(to_point_msg(positions, point + run.offset));
    }
  }
  for (Marker& marker : markers) {
    if (marker.points.empty()) marker.action = Marker::DELETE;
  }
  return markers;
}

/// Type of a primitive; RViz loads mesh files itself.
int type_of(const clothsim::Primitive& primitive) {
  switch (primitive.kind) {
    case clothsim::Primitive::Kind::ball:
      return Marker::SPHERE;
    case clothsim::Primitive::Kind::cylinder:
      return Marker::CYLINDER;
    case clothsim::Primitive::Kind::box:
      return Marker::CUBE;
    case clothsim::Primitive::Kind::file:
      break;
  }
  return Marker::MESH_RESOURCE;
}

/// The first primitive of collider i has the id i, its next ones have i + the number of colliders
/// and so on, so that all differ.
void add_collider(const clothsim::Simulator& simulator, int index, const std_msgs::Header& header,
                  std::vector<Marker>& markers) {
  const auto& colliders = simulator.scene().colliders;
  const clothsim::Pose& pose = simulator.collider_pose(index);
  const clothsim::Shape& shape = colliders[static_cast<size_t>(index)].shape;
  int id = index;
  const bool shown = simulator.collider_enabled(index);
  for (const clothsim::Primitive& part : clothsim::drawing_of(shape).primitives) {
    Marker marker = make_marker(header, "colliders", id, type_of(part), color(0.60f, 0.67f, 0.74f));
    set_scale(marker, part.size.x(), part.size.y(), part.size.z());
    marker.mesh_resource = part.uri;
    marker.pose = to_pose_msg({pose.position + pose.orientation * part.center, pose.orientation});
    if (!shown) marker.action = Marker::DELETE;
    markers.push_back(std::move(marker));
    id += static_cast<int>(colliders.size());
  }
}

void add_colliders(const clothsim::Simulator& simulator, const std_msgs::Header& header,
                   std::vector<Marker>& markers) {
  for (size_t i = 0; i < simulator.scene().colliders.size(); ++i) {
    add_collider(simulator, static_cast<int>(i), header, markers);
  }
}

Marker make_pins(const clothsim::Cloth& cloth, const clothsim::Points& positions,
                 const std_msgs::Header& header) {
  Marker marker = make_marker(header, "pins", 0, Marker::SPHERE_LIST, color(0.20f, 0.75f, 0.35f));
  set_scale(marker, pin_diameter, pin_diameter, pin_diameter);
  for (int point : cloth.pinned) marker.points.push_back(to_point_msg(positions, point));
  return marker;
}

}  // namespace

std::array<float, 3> cloth_color(std::size_t number) {
  constexpr std::array<std::array<float, 3>, 6> colors{{{0.85f, 0.33f, 0.25f},
                                                        {0.34f, 0.71f, 0.91f},
                                                        {0.94f, 0.89f, 0.26f},
                                                        {0.00f, 0.62f, 0.45f},
                                                        {0.80f, 0.47f, 0.65f},
                                                        {0.00f, 0.45f, 0.70f}}};
  return colors[number % colors.size()];
}

visualization_msgs::MarkerArray make_markers(const clothsim::Simulator& simulator,
                                             const std_msgs::Header& header) {
  const clothsim::Cloth& cloth = simulator.cloth();
  const clothsim::Points& positions = simulator.state().positions;

  visualization_msgs::MarkerArray array;
  add_surfaces(cloth, positions, header, array.markers);
  add_colliders(simulator, header, array.markers);
  if (!cloth.pinned.empty()) array.markers.push_back(make_pins(cloth, positions, header));
  return array;
}

visualization_msgs::MarkerArray make_spring_markers(const clothsim::Simulator& simulator,
                                                    const std_msgs::Header& header) {
  visualization_msgs::MarkerArray array;
  array.markers = make_springs(simulator.cloth(), simulator.state().positions, header);
  return array;
}

visualization_msgs::MarkerArray make_collider_markers(const clothsim::Simulator& simulator,
                                                      const std_msgs::Header& header) {
  visualization_msgs::MarkerArray array;
  add_colliders(simulator, header, array.markers);
  return array;
}

}  // namespace clothsim_ros
