#include "clothsim/ros/diagnostics.h"

namespace clothsim_ros {
namespace {

using diagnostic_msgs::DiagnosticStatus;

/// Share of the real-time factor asked for below which the node warns.
constexpr double slow_share = 0.95;

/// A shorter time holds too few frames to judge the rate by [s].
constexpr double shortest_measured = 0.5;

void fill_speed(const NodeStatus& status, diagnostic_updater::DiagnosticStatusWrapper& out) {
  out.add("real-time factor asked", status.factor_asked);
  if (!status.factor_reached) return;
  out.add("real-time factor", *status.factor_reached);
  if (*status.factor_reached < slow_share * status.factor_asked) {
    out.mergeSummaryf(DiagnosticStatus::WARN, "real-time factor %.2f of %.2f",
                      *status.factor_reached, status.factor_asked);
  }
}

void fill_step(const NodeStatus& status, diagnostic_updater::DiagnosticStatusWrapper& out) {
  const clothsim::StepReport& report = status.report;
  out.add("method", report.method);
  out.add("substeps", report.substeps);
  out.add("sweeps", report.sweeps);
  out.addf("worst stretch [%]", "%.2f", 100 * report.worst_stretch);
  out.add("contacts", report.contacts);
  if (status.intersecting_pairs) out.add("intersecting pairs", *status.intersecting_pairs);
}

void fill_frame(const FrameStatus& frame, diagnostic_updater::DiagnosticStatusWrapper& out) {
  const std::string key = "tf age of " + frame.frame + " [s]";
  if (!frame.seen) {
    out.add(key, "not seen yet");
    return;
  }
  out.addf(key, "%.3f", frame.age);
  if (frame.lost) out.mergeSummary(DiagnosticStatus::WARN, "lost tf frame " + frame.frame);
}

void fill(const NodeStatus& status, diagnostic_updater::DiagnosticStatusWrapper& out) {
  out.summary(DiagnosticStatus::OK, status.paused ? "paused" : "running");
  if (!status.failure.empty()) out.mergeSummary(DiagnosticStatus::ERROR, status.failure);
  fill_speed(status, out);
  fill_step(status, out);
  for (const FrameStatus& frame : status.frames) fill_frame(frame, out);
}

}  // namespace

void RateMeter::restart(double now) {
  start_ = now;
  simulated_ = 0;
}

std::optional<double> RateMeter::take(double now) {
  const double passed = now - start_;
  const double simulated = simulated_;
  if (passed >= 0 && passed < shortest_measured) return std::nullopt;
  restart(now);
  if (passed < 0) return std::nullopt;  // time jumped
  return simulated / passed;
}

Diagnostics::Diagnostics() {
  updater_.setHardwareID("none");
  updater_.add("simulation", [this](auto& out) { fill(status_, out); });
}

void Diagnostics::publish(const NodeStatus& status) {
  status_ = status;
  updater_.force_update();
}

}  // namespace clothsim_ros
