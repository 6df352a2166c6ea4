#include "clothsim/ros/choice_log.h"

#include <ros/console.h>

#include <iomanip>
#include <sstream>

namespace clothsim_ros {
namespace {

bool same(const clothsim::MethodChoice& a, const clothsim::MethodChoice& b) {
  return a.method == b.method && a.min_substeps == b.min_substeps &&
         a.predicted_error == b.predicted_error && a.is_feasible == b.is_feasible &&
         a.reasons.all() == b.reasons.all();
}

/// Warns of a slow method that the scene, or a live value, names.
void warn_if_slow(const clothsim::MethodChoice& choice) {
  if (choice.is_feasible) return;
  ROS_WARN(
      "Method %s is going to be slower than real time: some %.2g CPU seconds a simulated second, "
      "and more in contact. Method auto chooses one that keeps up where there is one",
      choice.method.c_str(), *choice.predicted_cost);
}

}  // namespace

void ChoiceLog::update(const clothsim::SimulationSpec& simulation,
                       const clothsim::MethodChoice& choice) {
  if (same(choice, told_)) return;
  told_ = choice;
  if (simulation.method != "auto") {
    warn_if_slow(choice);
    return;
  }
  const auto level = choice.is_feasible ? ros::console::levels::Info : ros::console::levels::Warn;
  std::ostringstream error;
  if (choice.predicted_error) {
    error << ", predicted error " << std::scientific << std::setprecision(1)
          << *choice.predicted_error << " of the cloth's size";
  }
  ROS_LOG_STREAM(level, ROSCONSOLE_DEFAULT_NAME,
                 "Method auto takes " << choice.method << ", substeps a frame "
                                      << choice.min_substeps << " or more" << error.str() << ": "
                                      << choice.reasons.text());
}

}  // namespace clothsim_ros
