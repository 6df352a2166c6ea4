#pragma once

#include <clothsim/ClothState.h>
#include <clothsim/ClothTopology.h>
#include <clothsim/Colliders.h>
#include <clothsim/WholeState.h>
#include <geometry_msgs/Pose.h>
#include <geometry_msgs/Quaternion.h>
#include <geometry_msgs/Transform.h>
#include <geometry_msgs/Vector3.h>
#include <geometry_msgs/Wrench.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/PointCloud2.h>
#include <std_msgs/Header.h>

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "clothsim/model/cloth.h"
#include "clothsim/model/state.h"
#include "clothsim/model/wrench.h"
#include "clothsim/render/camera.h"
#include "clothsim/shapes/collider.h"
#include "clothsim/simulation/grips.h"
#include "clothsim/simulation/simulator.h"

// Pure functions between the core's types and ROS messages.

namespace clothsim_ros {

/// Positions and velocities as flat float32 xyz, and the points held by grips. `step` counts frames
/// since the scene's start.
clothsim::ClothState to_state_msg(const clothsim::State&,
                                  const std::map<std::string, clothsim::Grip>&,
                                  const std_msgs::Header&, unsigned topology_seq,
                                  std::uint64_t step);

/// In full precision, with the simulator's memory.
clothsim::WholeState to_whole_state_msg(const clothsim::State&, const std::vector<double>& memory,
                                        std::uint64_t step);

/// Throws InvalidValue where numbers are left over after the last x, y, z.
clothsim::State to_state(const clothsim::WholeState&);

/// `parts`: ClothSpec::parts.
clothsim::ClothTopology to_topology_msg(const clothsim::Cloth&,
                                        const std::vector<clothsim::ClothPart>& parts,
                                        const std_msgs::Header&, unsigned topology_seq);

/// Organised cloud of columns x rows points, fields x, y, z as float32.
sensor_msgs::PointCloud2 to_point_cloud(const clothsim::Cloth&, const clothsim::Points& positions,
                                        const std_msgs::Header&);

/// The colliders' poses and the held points. `step` as above.
clothsim::Colliders to_colliders_msg(const clothsim::Simulator&, const std_msgs::Header&,
                                     std::uint64_t step);

/// Pinhole without distortion; K and P are the same.
sensor_msgs::CameraInfo to_camera_info(const clothsim::Camera&, const std_msgs::Header&);

clothsim::Vector3 to_vector(const geometry_msgs::Vector3&);
geometry_msgs::Vector3 to_vector_msg(const clothsim::Vector3&);
geometry_msgs::Point to_point_msg(const clothsim::Vector3&);
geometry_msgs::Point to_point_msg(const clothsim::Points&, int point);
geometry_msgs::Quaternion to_quaternion_msg(const Eigen::Quaterniond&);
/// The wrench in axes that are rotated by `frame` against its own.
geometry_msgs::Wrench to_wrench_msg(
    const clothsim::Wrench&, const Eigen::Quaterniond& frame = Eigen::Quaterniond::Identity());
geometry_msgs::Pose to_pose_msg(const clothsim::Pose&);
geometry_msgs::Transform to_transform_msg(const clothsim::Pose&);

/// Both normalise the rotation. Not finite where the message is not, or where its rotation is zero.
clothsim::Pose to_pose(const geometry_msgs::Transform&);
clothsim::Pose to_pose(const geometry_msgs::Pose&);

}  // namespace clothsim_ros
