#include "clothsim/ros/choice_log.h"

#include <ros/console.h>

namespace clothsim_ros {
namespace {

bool same(const clothsim::MethodChoice& a, const clothsim::MethodChoice& b) {
  return a.method == b.method && a.least_substeps == b.least_substeps &&
         a.predicted_error == b.predicted_error && a.is_feasible == b.is_feasible;
}

}  // namespace

void ChoiceLog::update(const clothsim::SimulationSpec& simulation,
                       const clothsim::MethodChoice& choice) {
  const bool is_news = simulation.method == "auto" && !same(choice, told_);
  told_ = simulation.method == "auto" ? choice : clothsim::MethodChoice{};
  if (!is_news) return;
  const auto level = choice.is_feasible ? ros::console::levels::Info : ros::console::levels::Warn;
  ROS_LOG(level, ROSCONSOLE_DEFAULT_NAME,
          "Method auto takes %s, substeps a frame %d or more, predicted error %.1e of the cloth's "
          "size: %s",
          choice.method.c_str(), choice.least_substeps, choice.predicted_error,
          choice.reason.c_str());
}

}  // namespace clothsim_ros
