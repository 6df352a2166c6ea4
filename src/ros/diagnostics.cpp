#include "clothsim/ros/diagnostics.h"

#include <diagnostic_msgs/DiagnosticArray.h>
#include <diagnostic_updater/DiagnosticStatusWrapper.h>
#include <ros/console.h>

#include <algorithm>
#include <array>
#include <iomanip>
#include <iterator>
#include <set>
#include <sstream>
#include <string>
#include <utility>

#include "clothsim/model/checks.h"

namespace clothsim_ros {
namespace {

using diagnostic_msgs::DiagnosticStatus;
using Wrapper = diagnostic_updater::DiagnosticStatusWrapper;

constexpr std::uint32_t diagnostics_queue = 1;

/// Smallest lag of a pin or a grip that is reported [m].
constexpr double told_lag = 1e-3;

/// Above this share of its strength, a holder pulls at its limit: friction takes the rest.
constexpr double nearly_all = 0.85;

constexpr const char* no_clock = "waits for /clock: /use_sim_time is true, but no time has come";

/// The level of a value whose limit is a lower bound; below, an upper bound.
std::int8_t level_at_least(double value, const Limit& limit) {
  if (limit.error && value < *limit.error) return DiagnosticStatus::ERROR;
  if (limit.warning && value < *limit.warning) return DiagnosticStatus::WARN;
  return DiagnosticStatus::OK;
}

std::int8_t level_at_most(double value, const Limit& limit) {
  if (limit.error && value > *limit.error) return DiagnosticStatus::ERROR;
  if (limit.warning && value > *limit.warning) return DiagnosticStatus::WARN;
  return DiagnosticStatus::OK;
}

/// Text for a node that spends most time in simulation; it names the method, where the scene's
/// choice is too slow.
std::string simulating(const NodeStatus& status) {
  std::string text = "most of its time goes into simulating";
  const double cost = status.time.simulating / *status.factor_reached;
  const bool is_named = status.report.reasons.has(clothsim::Reason::named_by_scene);
  if (!is_named || cost * status.factor_asked < 1) return text;
  std::ostringstream number;
  number << std::setprecision(2) << cost;
  return text + ": method " + status.report.method + " takes " + number.str() +
         " CPU seconds a simulated second, and auto may take less";
}

/// The cause of a missed real-time factor. Other programs are the cause only where the node would
/// keep up without them.
std::string bottleneck(const NodeStatus& status) {
  const TimeShares::Shares& time = status.time;
  const double own = time.simulating + time.publishing + time.serving;
  const bool keeps_up_alone = own * status.factor_asked <= *status.factor_reached;
  const std::array<std::pair<double, std::string>, 4> uses = {
      {{time.simulating, simulating(status)},
       {time.publishing, "most of its time goes into publishing"},
       {time.serving, "most of its time goes into calls and live values"},
       {keeps_up_alone ? time.kept : 0, "the computer is busy with other work"}}};
  return std::max_element(uses.begin(), uses.end())->second;
}

void fill_speed(const NodeStatus& status, const Limit& limit, Wrapper& out) {
  out.add("real-time factor asked", status.factor_asked);
  const auto add_share = [&out](const char* key, double share) {
    out.addf(std::string("time for ") + key + " [%]", "%.1f", 100 * share);
  };
  add_share("simulating", status.time.simulating);
  add_share("publishing", status.time.publishing);
  add_share("calls and live values", status.time.serving);
  add_share("other work of the computer", status.time.kept);
  if (!status.factor_reached) return;
  out.add("real-time factor", *status.factor_reached);
  if (status.factor_asked == 0) return;
  const std::int8_t level = level_at_least(*status.factor_reached / status.factor_asked, limit);
  if (level != DiagnosticStatus::OK) {
    out.mergeSummaryf(static_cast<unsigned char>(level), "real-time factor %.2f of %.2f: %s",
                      *status.factor_reached, status.factor_asked, bottleneck(status).c_str());
  }
}

void fill_step(const NodeStatus& status, const DiagnosticLimits& limits, Wrapper& out) {
  const clothsim::StepReport& report = status.report;
  out.add("method", report.method);
  out.add("substeps", report.substeps);
  out.add("reason", report.reasons.text());
  if (report.predicted_error) out.addf("predicted error", "%.1e", *report.predicted_error);
  if (report.ran_out > 0) {
    out.mergeSummaryf(DiagnosticStatus::WARN,
                      "Newton's method ran out of iterations in %d of %d substeps", report.ran_out,
                      report.substeps);
  }
  out.add("sweeps", report.sweeps);
  out.addf("worst stretch [%]", "%.2f", 100 * report.worst_stretch);
  if (status.is_limited) {
    const double violation = report.violation;
    out.addf("violation of the strain limit [%]", "%.2f", 100 * violation);
    const std::int8_t level = level_at_most(violation, limits.violation);
    if (level != DiagnosticStatus::OK) {
      out.mergeSummaryf(static_cast<unsigned char>(level),
                        "a spring is %.1f %% over the strain limit", 100 * violation);
    }
  }
  out.add("contacts", report.contacts);
  // Points in a gripper, or slipping out of one, are no fault.
  out.add("points between colliders", report.pinched);
  out.add("slipping between colliders", report.slipping);
  if (status.intersecting_pairs) {
    const int pairs = *status.intersecting_pairs;
    out.add("intersecting pairs", pairs);
    out.add("moves held back", report.held_back);
    if (report.held_back > 0) {
      out.mergeSummaryf(DiagnosticStatus::WARN,
                        "%d moves of points held back: the cloth itself is in the way",
                        report.held_back);
    }
    const std::int8_t level = level_at_most(pairs, limits.crossings);
    if (level != DiagnosticStatus::OK) {
      out.mergeSummaryf(static_cast<unsigned char>(level), "%d pairs of triangles cross", pairs);
    }
  }
}

/// The holder with the largest lag, in words, and the number of holders that lag.
void fill_holders(const std::vector<clothsim::HolderReport>& holders, Wrapper& out) {
  const auto last = std::max_element(holders.begin(), holders.end(),
                                     [](const auto& a, const auto& b) { return a.lag < b.lag; });
  const auto count = std::count_if(holders.begin(), holders.end(),
                                   [](const auto& holder) { return holder.lag > told_lag; });
  out.add("holders that lag", count);
  if (count == 0) return;
  const bool is_overpowered = last->force > nearly_all * last->strength;
  out.mergeSummaryf(DiagnosticStatus::WARN, "%s lags by %.0f mm: it pulls with %s%.3g N%s",
                    last->name.c_str(), 1e3 * last->lag, is_overpowered ? "all its " : "",
                    is_overpowered ? last->strength : last->force,
                    is_overpowered ? "" : ", and a collider or the cloth itself is in the way");
}

void fill_frame(const FrameStatus& frame, const Limit& limit, Wrapper& out) {
  const std::string key = "tf age of " + frame.frame + " [s]";
  if (!frame.seen) {
    out.add(key, frame.apart_from.empty() ? "not seen yet" : "no transform to " + frame.apart_from);
    if (!frame.apart_from.empty()) {
      out.mergeSummary(
          DiagnosticStatus::WARN,
          "tf frame " + frame.frame + " has no transform to the world frame, " + frame.apart_from);
    }
    return;
  }
  out.addf(key, "%.3f", frame.age);
  std::int8_t level = level_at_most(frame.age, limit);
  if (frame.lost) level = std::max(level, std::int8_t{DiagnosticStatus::WARN});
  if (level != DiagnosticStatus::OK) {
    out.mergeSummary(static_cast<unsigned char>(level), "lost tf frame " + frame.frame);
  }
}

/// Reports each frame once, for any number of colliders, pins and points that follow it.
void fill_frames(const std::vector<FrameStatus>& frames, const Limit& limit, Wrapper& out) {
  std::set<std::string> told;
  for (const FrameStatus& frame : frames) {
    if (told.insert(frame.frame).second) fill_frame(frame, limit, out);
  }
}

void fill(const NodeStatus& status, const DiagnosticLimits& limits, Wrapper& out) {
  out.summary(DiagnosticStatus::OK, status.paused ? "paused" : "running");
  out.add("paused", status.paused);
  if (status.waits_for_clock) out.summary(DiagnosticStatus::WARN, no_clock);
  if (!status.failure.empty()) out.mergeSummary(DiagnosticStatus::ERROR, status.failure);
  fill_speed(status, limits.speed, out);
  fill_step(status, limits, out);
  fill_holders(status.holders, out);
  fill_frames(status.frames, limits.tf_age, out);
}

std::string names(const clothsim::WantedImages& wanted) {
  std::vector<std::string> names;
  const auto add = [&names](bool is_there, const char* name) {
    if (is_there) names.emplace_back(name);
  };
  add(wanted.color, "color");
  add(wanted.depth, "depth");
  add(wanted.mask, "mask");
  add(wanted.uv, "uv");
  add(wanted.normals, "normals");
  add(wanted.flow, "flow");
  add(wanted.visible_points, "visible_points");
  return names.empty() ? "none" : clothsim::join(names);
}

void fill_camera(const CameraStatus& camera, const DiagnosticLimits& limits, Wrapper& out) {
  const clothsim::RenderStatus& render = camera.render;
  const std::string subscribed = names(camera.subscribed);
  out.summary(DiagnosticStatus::OK, "images: " + subscribed);
  if (!render.failure.empty())
    out.mergeSummary(DiagnosticStatus::WARN, "no images: " + render.failure);
  out.add("images subscribed", subscribed);
  out.add("pictures drawn", render.drawn);
  out.add("pictures dropped", render.dropped);
  if (camera.rate) out.addf("pictures per second", "%.1f", *camera.rate);
  if (camera.drawn_share) {
    const std::int8_t level = level_at_least(*camera.drawn_share, limits.images);
    if (level != DiagnosticStatus::OK) {
      out.mergeSummaryf(static_cast<unsigned char>(level), "%.0f %% of the pictures due are drawn",
                        100 * *camera.drawn_share);
    }
  }
  out.add("OpenGL", render.device.empty() ? "not in use" : render.device);
  const auto add_time = [&out](const char* key, double seconds) {
    out.addf(key, "%.2f", 1e3 * seconds);
  };
  add_time("upload [ms]", render.times.upload);
  add_time("draw [ms]", render.times.draw);
  add_time("read back [ms]", render.times.read);
  if (camera.frame) fill_frame(*camera.frame, limits.tf_age, out);
}

std::set<std::string> lost_frames(const NodeStatus& status) {
  std::set<std::string> lost;
  const auto add = [&lost](const FrameStatus& frame) {
    if (frame.lost) lost.insert(frame.frame);
  };
  std::for_each(status.frames.begin(), status.frames.end(), add);
  for (const CameraStatus& camera : status.cameras) {
    if (camera.frame) add(*camera.frame);
  }
  return lost;
}

/// Warns of the frames that were lost between two statuses, in one line: those of a robot are lost
/// together.
void warn_of_lost(const NodeStatus& before, const NodeStatus& now) {
  const std::set<std::string> known = lost_frames(before);
  const std::set<std::string> lost = lost_frames(now);
  std::vector<std::string> added;
  std::set_difference(lost.begin(), lost.end(), known.begin(), known.end(),
                      std::back_inserter(added));
  if (added.empty()) return;
  ROS_WARN("Lost tf frame%s %s: what they carry stays where it was", added.size() == 1 ? "" : "s",
           clothsim::join(added).c_str());
}

}  // namespace

Diagnostics::Diagnostics(ros::NodeHandle& node, const DiagnosticLimits& limits)
    : name_(node.getNamespace().substr(1)),
      limits_(limits),
      publisher_(
          node.advertise<diagnostic_msgs::DiagnosticArray>("/diagnostics", diagnostics_queue)) {}

void Diagnostics::publish(const NodeStatus& status) {
  // Warn a second later only: the clock may be about to start.
  if (status.waits_for_clock && status_.waits_for_clock) ROS_WARN_ONCE("%s", no_clock);
  warn_of_lost(status_, status);
  status_ = status;

  // diagnostic_updater's Updater is no option: it adds a period to ROS time, which throws near the
  // end of its range.
  diagnostic_msgs::DiagnosticArray array;
  array.header.stamp = ros::Time::now();
  const auto add = [this, &array](const std::string& part, const auto& fill_in) {
    Wrapper out;
    out.name = name_ + ": " + part;
    out.hardware_id = "none";
    fill_in(out);
    array.status.push_back(out);
  };
  add("simulation", [&](Wrapper& out) { fill(status, limits_, out); });
  for (const CameraStatus& camera : status.cameras) {
    add(camera.name, [&](Wrapper& out) { fill_camera(camera, limits_, out); });
  }
  publisher_.publish(array);
}

}  // namespace clothsim_ros
