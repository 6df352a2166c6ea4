#include "clothsim/ros/conversions.h"

#include <sensor_msgs/distortion_models.h>

#include <algorithm>
#include <array>
#include <map>
#include <string>

#include "clothsim/model/errors.h"

namespace clothsim_ros {
namespace {

using FlatXyz = Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>;
using FlatUv = Eigen::Matrix<float, Eigen::Dynamic, 2, Eigen::RowMajor>;

using ExactXyz = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

/// The table row by row, in the precision of `Flat`.
template <class Flat, class Table>
auto flatten(const Table& table) {
  using Number = typename Flat::Scalar;
  std::vector<Number> flat(static_cast<size_t>(table.size()));
  Eigen::Map<Flat>(flat.data(), table.rows(), table.cols()) = table.template cast<Number>();
  return flat;
}

clothsim::Points to_points(const std::string& key, const std::vector<double>& flat) {
  if (flat.size() % 3 != 0) {
    throw clothsim::InvalidValue({key}, std::to_string(flat.size()) + " numbers",
                                 "three for each point");
  }
  return Eigen::Map<const ExactXyz>(flat.data(), static_cast<Eigen::Index>(flat.size() / 3), 3);
}

/// A message with fields x, y and z.
template <class Message>
Message to_xyz(const clothsim::Vector3& vector) {
  Message msg;
  msg.x = vector.x();
  msg.y = vector.y();
  msg.z = vector.z();
  return msg;
}

/// A pose from a message with fields x, y and z and a rotation, which is normalised.
template <class Message>
clothsim::Pose make_pose(const Message& p, const geometry_msgs::Quaternion& r) {
  const Eigen::Quaterniond rotation(r.w, r.x, r.y, r.z);
  return {{p.x, p.y, p.z}, Eigen::Quaterniond(rotation.coeffs() / rotation.norm())};
}

}  // namespace

clothsim::ClothState to_state_msg(const clothsim::State& state,
                                  const std::map<std::string, clothsim::Grip>& grips,
                                  const std_msgs::Header& header, unsigned topology_seq,
                                  std::uint64_t step) {
  clothsim::ClothState msg;
  msg.header = header;
  msg.topology_seq = topology_seq;
  msg.step = step;
  msg.time = state.time;
  msg.positions = flatten<FlatXyz>(state.positions);
  msg.velocities = flatten<FlatXyz>(state.velocities);
  for (const auto& [frame, grip] : grips) {
    for (const clothsim::Grip::Held& held : grip.held) {
      msg.held.push_back(static_cast<std::uint32_t>(held.point));
    }
  }
  std::sort(msg.held.begin(), msg.held.end());
  return msg;
}

clothsim::WholeState to_whole_state_msg(const clothsim::State& state,
                                        const std::vector<double>& memory, std::uint64_t step) {
  clothsim::WholeState msg;
  msg.step = step;
  msg.time = state.time;
  msg.positions = flatten<ExactXyz>(state.positions);
  msg.velocities = flatten<ExactXyz>(state.velocities);
  msg.memory = memory;
  return msg;
}

clothsim::State to_state(const clothsim::WholeState& msg) {
  return {to_points("positions", msg.positions), to_points("velocities", msg.velocities), msg.time};
}

clothsim::ClothTopology to_topology_msg(const clothsim::Cloth& cloth,
                                        const std::vector<clothsim::ClothPart>& parts,
                                        const std_msgs::Header& header, unsigned topology_seq) {
  clothsim::ClothTopology msg;
  msg.header = header;
  msg.seq = topology_seq;
  msg.columns = static_cast<std::uint32_t>(cloth.columns);
  msg.rows = static_cast<std::uint32_t>(cloth.rows);
  for (const auto& triangle : cloth.triangles) {
    msg.triangles.insert(msg.triangles.end(), triangle.begin(), triangle.end());
  }

  const std::array<std::vector<std::uint32_t>*, 3> families = {&msg.structural, &msg.shear,
                                                               &msg.bending};
  for (const clothsim::SpringRun& run : cloth.springs) {
    for (int point = run.first; point < run.first + run.count; ++point) {
      auto& ends = *families[static_cast<size_t>(run.family)];
      ends.push_back(static_cast<std::uint32_t>(point));
      ends.push_back(static_cast<std::uint32_t>(point + run.offset));
    }
  }

  msg.uv = flatten<FlatUv>(cloth.uv);
  msg.rest_positions = flatten<FlatXyz>(cloth.rest_positions);
  msg.pinned.assign(cloth.pinned.begin(), cloth.pinned.end());
  for (const clothsim::ClothPart& part : parts) {
    msg.cloths.push_back(part.name);
    msg.first_points.push_back(static_cast<std::uint32_t>(part.first_point));
    msg.cloth_columns.push_back(static_cast<std::uint32_t>(part.columns));
  }
  return msg;
}

sensor_msgs::PointCloud2 to_point_cloud(const clothsim::Cloth& cloth,
                                        const clothsim::Points& positions,
                                        const std_msgs::Header& header) {
  constexpr std::uint32_t point_step = 3 * sizeof(float);

  sensor_msgs::PointCloud2 msg;
  msg.header = header;
  msg.width = static_cast<std::uint32_t>(cloth.columns);
  msg.height = static_cast<std::uint32_t>(cloth.rows);
  for (const char* name : {"x", "y", "z"}) {
    sensor_msgs::PointField field;
    field.name = name;
    field.offset = static_cast<std::uint32_t>(msg.fields.size() * sizeof(float));
    field.datatype = sensor_msgs::PointField::FLOAT32;
    field.count = 1;
    msg.fields.push_back(field);
  }
  msg.point_step = point_step;
  msg.row_step = point_step * msg.width;
  msg.is_dense = true;
  msg.data.resize(size_t{msg.row_step} * msg.height);
  Eigen::Map<FlatXyz>(reinterpret_cast<float*>(msg.data.data()), positions.rows(), 3) =
      positions.cast<float>();
  return msg;
}

clothsim::Colliders to_colliders_msg(const clothsim::Simulator& simulator,
                                     const std_msgs::Header& header, std::uint64_t step) {
  clothsim::Colliders msg;
  msg.header = header;
  msg.step = step;
  const clothsim::Scene& scene = simulator.scene();
  for (std::size_t i = 0; i < scene.colliders.size(); ++i) {
    clothsim::ColliderState collider;
    collider.name = scene.colliders[i].name;
    collider.frame = scene.colliders[i].frame;
    collider.pose = to_pose_msg(simulator.collider_pose(static_cast<int>(i)));
    collider.enabled = simulator.collider_enabled(static_cast<int>(i));
    collider.friction = scene.colliders[i].friction;
    msg.colliders.push_back(collider);
  }

  const std::vector<clothsim::HolderReport> holders = simulator.holders();
  auto holder = holders.begin();
  const auto tell = [&](clothsim::HeldPoints& held) {
    held.strength = holder->strength;
    held.force = std::max(held.force, holder->force);
    held.lag = std::max(held.lag, holder->lag);
    ++holder;
  };
  std::map<std::string, clothsim::HeldPoints> pinned;  // by frame
  for (const clothsim::Pin& pin : scene.cloth.pinned) {
    pinned[pin.frame].points.push_back(pin.row * scene.cloth.columns + pin.column);
    tell(pinned[pin.frame]);
  }
  for (auto& [frame, held] : pinned) {
    held.frame = frame;
    held.pinned = true;
    msg.held.push_back(held);
  }
  for (const auto& [frame, grip] : simulator.grips()) {
    clothsim::HeldPoints held;
    held.frame = frame;
    for (const clothsim::Grip::Held& point : grip.held) held.points.push_back(point.point);
    held.tear_force = grip.tear_force.value_or(0);
    tell(held);
    msg.held.push_back(held);
  }
  return msg;
}

sensor_msgs::CameraInfo to_camera_info(const clothsim::Camera& camera,
                                       const std_msgs::Header& header) {
  sensor_msgs::CameraInfo msg;
  msg.header = header;
  msg.width = static_cast<std::uint32_t>(camera.width);
  msg.height = static_cast<std::uint32_t>(camera.height);
  msg.distortion_model = sensor_msgs::distortion_models::PLUMB_BOB;
  msg.D.assign(5, 0);
  msg.K = {camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1};
  msg.R = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  msg.P = {camera.fx, 0, camera.cx, 0, 0, camera.fy, camera.cy, 0, 0, 0, 1, 0};
  return msg;
}

clothsim::Vector3 to_vector(const geometry_msgs::Vector3& message) {
  return {message.x, message.y, message.z};
}

geometry_msgs::Vector3 to_vector_msg(const clothsim::Vector3& vector) {
  return to_xyz<geometry_msgs::Vector3>(vector);
}

geometry_msgs::Point to_point_msg(const clothsim::Vector3& point) {
  return to_xyz<geometry_msgs::Point>(point);
}

geometry_msgs::Point to_point_msg(const clothsim::Points& points, int point) {
  return to_point_msg(clothsim::Vector3(points.row(point)));
}

geometry_msgs::Quaternion to_quaternion_msg(const Eigen::Quaterniond& rotation) {
  geometry_msgs::Quaternion msg;
  msg.x = rotation.x();
  msg.y = rotation.y();
  msg.z = rotation.z();
  msg.w = rotation.w();
  return msg;
}

geometry_msgs::Wrench to_wrench_msg(const clothsim::Wrench& wrench,
                                    const Eigen::Quaterniond& frame) {
  const Eigen::Quaterniond to_frame = frame.conjugate();
  geometry_msgs::Wrench msg;
  msg.force = to_vector_msg(to_frame * wrench.force);
  msg.torque = to_vector_msg(to_frame * wrench.torque);
  return msg;
}

geometry_msgs::Pose to_pose_msg(const clothsim::Pose& pose) {
  geometry_msgs::Pose msg;
  msg.position = to_point_msg(pose.position);
  msg.orientation = to_quaternion_msg(pose.orientation);
  return msg;
}

geometry_msgs::Transform to_transform_msg(const clothsim::Pose& pose) {
  geometry_msgs::Transform msg;
  msg.translation = to_vector_msg(pose.position);
  msg.rotation = to_quaternion_msg(pose.orientation);
  return msg;
}

clothsim::Pose to_pose(const geometry_msgs::Transform& transform) {
  return make_pose(transform.translation, transform.rotation);
}

clothsim::Pose to_pose(const geometry_msgs::Pose& pose) {
  return make_pose(pose.position, pose.orientation);
}

}  // namespace clothsim_ros
