#include "clothsim/ros/choice_log.h"

#include <ros/console.h>

#include <iomanip>
#include <sstream>

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
  std::ostringstream error;
  if (choice.predicted_error) {
    error << ", predicted error " << std::scientific << std::setprecision(1)
          << *choice.predicted_error << " of the cloth's size";
  }
  ROS_LOG_STREAM(level, ROSCONSOLE_DEFAULT_NAME,
                 "Method auto takes " << choice.method << ", substeps a frame "
                                      << choice.least_substeps << " or more" << error.str() << ": "
                                      << choice.reasons.text());
}

}  // namespace clothsim_ros
