#include <clothsim/ClothState.h>
#include <clothsim/Step.h>
#include <gtest/gtest.h>
#include <nodelet/loader.h>
#include <ros/ros.h>
#include <tf2_ros/transform_broadcaster.h>
#include <visualization_msgs/MarkerArray.h>

#include <functional>

namespace {

/// Long enough for a machine that is busy with other work.
const ros::WallDuration patience(30);

bool wait_for(const std::function<bool()>& condition) {
  const ros::SteadyTime end = ros::SteadyTime::now() + patience;
  while (ros::SteadyTime::now() < end) {
    ros::spinOnce();
    if (condition()) return true;
    ros::WallDuration(0.01).sleep();
  }
  return false;
}

clothsim::Step::Response step(std::uint32_t frames) {
  clothsim::Step service;
  service.request.frames = frames;
  EXPECT_TRUE(ros::service::call("/a/cloth/step", service));
  EXPECT_TRUE(service.response.success) << service.response.message;
  return service.response;
}

/// The node under the name of /a/cloth, in this process.
class Nodelet : public testing::Test {
 protected:
  Nodelet() : loader_(false) {
    EXPECT_TRUE(loader_.load("/a/cloth", "clothsim/ClothNodelet", {}, {}));
  }

  ros::NodeHandle node_;
  nodelet::Loader loader_;
};

TEST_F(Nodelet, PublishesUnderItsOwnName) {
  clothsim::ClothState::ConstPtr state;
  const ros::Subscriber subscriber = node_.subscribe<clothsim::ClothState>(
      "/a/cloth/state", 10, [&](const auto& message) { state = message; });
  ASSERT_TRUE(wait_for([&] { return state != nullptr; })) << "a newcomer gets the present state";
  EXPECT_EQ(state->step, 0u);
  const clothsim::Step::Response answer = step(3);
  ASSERT_TRUE(wait_for([&] { return state->step == 3; }));
  EXPECT_EQ(state->positions, answer.state.positions);
}

/// The transform comes from a node of the same name, as for all nodelets of a process.
TEST_F(Nodelet, HearsTransformsOfItsNeighbours) {
  double x = 0;
  const ros::Subscriber subscriber = node_.subscribe<visualization_msgs::MarkerArray>(
      "/a/cloth/markers/colliders", 10, [&](const auto& array) {
        for (const auto& marker : array->markers) {
          if (marker.ns == "colliders" && marker.id == 0) x = marker.pose.position.x;
        }
      });
  ASSERT_TRUE(wait_for([&] { return x == 0.5; })) << "where the scene has the ball";
  tf2_ros::TransformBroadcaster broadcaster;
  geometry_msgs::TransformStamped ball;
  ball.header.frame_id = "map";
  ball.child_frame_id = "ball";
  ball.transform.translation.x = 0.75;
  ball.transform.translation.z = 0.3;
  ball.transform.rotation.w = 1;
  EXPECT_TRUE(wait_for([&] {
    ball.header.stamp = ros::Time::now();
    broadcaster.sendTransform(ball);
    step(1);
    return x == 0.75;
  }));
}

TEST_F(Nodelet, EndsWhenItIsUnloaded) {
  EXPECT_TRUE(ros::service::waitForService("/a/cloth/step", 1000));
  EXPECT_TRUE(loader_.unload("/a/cloth"));
  EXPECT_FALSE(ros::service::exists("/a/cloth/step", false));
  EXPECT_TRUE(loader_.load("/a/cloth", "clothsim/ClothNodelet", {}, {}));
  step(1);
}

TEST_F(Nodelet, ABadParameterIsRefused) {
  EXPECT_FALSE(loader_.load("/bad", "clothsim/ClothNodelet", {}, {}));
  step(1);  // the other one goes on
}

}  // namespace

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "nodelet_test");
  const ros::NodeHandle alive;
  return RUN_ALL_TESTS();
}
