#include "clothsim/ros/stress_topic.h"

#include <clothsim/Stress.h>

#include <array>
#include <utility>
#include <vector>

#include "clothsim/dynamics/membrane_stress.h"
#include "clothsim/dynamics/springs.h"

namespace clothsim_ros {
namespace {

/// Messages queued for a slow subscriber: about a second's.
constexpr std::uint32_t stress_queue = 100;

}  // namespace

StressTopic::StressTopic(ros::NodeHandle& node, const clothsim::Simulator& simulator,
                         std::string world_frame)
    : simulator_(simulator),
      world_frame_(std::move(world_frame)),
      publisher_(node.advertise<clothsim::Stress>("stress", stress_queue)) {}

void StressTopic::publish(const ros::Time& stamp, std::uint64_t step) const {
  if (publisher_.getNumSubscribers() == 0) return;
  const clothsim::Cloth& cloth = simulator_.cloth();
  const std::vector<double> tensions = simulator_.tensions();
  clothsim::Stress msg;
  msg.header.stamp = stamp;
  msg.header.frame_id = world_frame_;
  msg.step = step;
  msg.topology_seq = simulator_.topology_seq();
  const std::array<std::vector<float>*, 3> families = {&msg.structural, &msg.shear, &msg.bending};
  auto tension = tensions.begin();
  clothsim::for_each_spring(cloth, [&](const clothsim::SpringRun& run, int, int) {
    families[static_cast<std::size_t>(run.family)]->push_back(static_cast<float>(*tension++));
  });
  const clothsim::Points stress = clothsim::membrane_stress(cloth, simulator_.state(), tensions);
  for (Eigen::Index i = 0; i < stress.rows(); ++i) {
    for (int part = 0; part < 3; ++part) {
      msg.triangles.push_back(static_cast<float>(stress(i, part)));
    }
  }
  publisher_.publish(msg);
}

}  // namespace clothsim_ros
