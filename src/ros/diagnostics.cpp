#include "clothsim/ros/diagnostics.h"

namespace clothsim_ros {
namespace {

using diagnostic_msgs::DiagnosticStatus;

/// Share of the real-time factor asked for below which the node warns.
constexpr double slow_share = 0.95;

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
  out.add("reason", report.reason);
  out.addf("predicted error", "%.1e", report.predicted_error);
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

std::string names(const clothsim::Outputs& outputs) {
  std::string text;
  const auto add = [&text](bool is_there, const char* name) {
    if (is_there) text += (text.empty() ? "" : ", ") + std::string(name);
  };
  add(outputs.color, "color");
  add(outputs.depth, "depth");
  add(outputs.mask, "mask");
  return text.empty() ? "none" : text;
}

void fill_camera(const CameraStatus& camera, diagnostic_updater::DiagnosticStatusWrapper& out) {
  const clothsim::RenderStatus& render = camera.render;
  const std::string subscribed = names(camera.subscribed);
  out.summary(DiagnosticStatus::OK, "images: " + subscribed);
  if (!render.failure.empty())
    out.mergeSummary(DiagnosticStatus::WARN, "no images: " + render.failure);
  out.add("images subscribed", subscribed);
  out.add("pictures drawn", render.drawn);
  out.add("pictures dropped", render.dropped);
  if (camera.rate) out.addf("pictures per second", "%.1f", *camera.rate);
  out.add("OpenGL", render.device.empty() ? "not in use" : render.device);
  const auto add_time = [&out](const char* key, double seconds) {
    out.addf(key, "%.2f", 1e3 * seconds);
  };
  add_time("upload [ms]", render.times.upload);
  add_time("draw [ms]", render.times.draw);
  add_time("read back [ms]", render.times.read);
  if (camera.frame) fill_frame(*camera.frame, out);
}

}  // namespace

Diagnostics::Diagnostics() {
  updater_.setHardwareID("none");
  updater_.add("simulation", [this](auto& out) { fill(status_, out); });
  updater_.add("camera", [this](auto& out) { fill_camera(status_.camera, out); });
}

void Diagnostics::publish(const NodeStatus& status) {
  status_ = status;
  updater_.force_update();
}

}  // namespace clothsim_ros
