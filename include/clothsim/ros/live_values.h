#pragma once

#include <dynamic_reconfigure/server.h>
#include <ros/console.h>
#include <ros/node_handle.h>

#include <algorithm>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "clothsim/model/errors.h"

namespace clothsim_ros {

/// The message of an error with the name of the live parameter: in namespace `ns`, the key
/// {"simulation", "gravity", "2"} is `ns`/gravity_z, {"cloth", "color", "0"} is `ns`/color_r.
std::string live_message(const clothsim::InvalidValue&, const std::string& ns);

/// Calls `apply` and returns the message of its refusal, with names in namespace `ns`; empty:
/// accepted.
std::optional<std::string> refusal(const std::function<void()>& apply, const std::string& ns);

/// The first value of a message, as "name value".
std::string text_of(const dynamic_reconfigure::Config&);

/// Values that dynamic_reconfigure changes, in the namespace of a node handle. `Generated` is the
/// class made from a .cfg file.
template <class Generated>
class LiveValues {
 public:
  /// Its functions hide those of the generated class, which the library calls by these names.
  struct Config : Generated {
    Config() = default;
    Config(const Generated& config) : Generated(config) {}

    // NOLINTBEGIN(bugprone-reserved-identifier)
    /// The limits in the .cfg are for sliders. The server would silently clamp a value to them;
    /// `apply` should accept or refuse the value itself.
    void __clamp__() {}

    /// Each value is a call to the master, some 1 ms in which no frame runs: sends only changed
    /// values.
    void __toServer__(const ros::NodeHandle& node) const {
      for (const auto& value : Generated::__getParamDescriptions__()) {
        if (!known || !*known || differs(*value, **known)) value->toServer(node, *this);
      }
      if (known) *known = *this;
    }
    // NOLINTEND(bugprone-reserved-identifier)

    template <class Description>
    bool differs(const Description& value, const Generated& other) const {
      dynamic_reconfigure::Config mine;
      dynamic_reconfigure::Config others;
      value.toMessage(mine, *this);
      value.toMessage(others, other);
      return mine != others;
    }

    std::optional<Generated>* known = nullptr;  // the values at the master
  };

  /// Starts from `start`, independent of an earlier node's values on the parameter server, and
  /// applies it. `apply` throws to refuse a request, which is logged and answered with the values
  /// in effect.
  LiveValues(const ros::NodeHandle& node, const Generated& start,
             std::function<void(const Generated&)> apply)
      : start_(start), accepted_(start), apply_(std::move(apply)) {
    accepted_.known = &known_;
    accepted_.__toServer__(node);  // the server begins with the values at the master
    server_.emplace(mutex_, node);
    server_->updateConfig(accepted_);
    server_->setCallback([this, ns = node.getNamespace()](Config& config, std::uint32_t) {
      // dynamic_reconfigure would keep the values of a callback that throws.
      if (const auto why = refusal([&] { apply_(config); }, ns)) {
        ROS_ERROR("%s", why->c_str());
        config = accepted_;
      } else {
        accepted_ = config;
      }
    });
  }

  /// The names of all values, below the namespace.
  static std::vector<std::string> names() {
    std::vector<std::string> all;
    for (const auto& value : Generated::__getParamDescriptions__()) all.push_back(value->name);
    return all;
  }

  /// The values of the start.
  const Generated& start() const { return start_; }

  /// The values in effect.
  const Generated& accepted() const { return accepted_; }

  /// The values that differ from the start's, as "name value"; from any thread.
  std::vector<std::string> changed() {
    const boost::recursive_mutex::scoped_lock lock(mutex_);
    std::vector<std::string> all;
    for (const auto& value : Generated::__getParamDescriptions__()) {
      if (!accepted_.differs(*value, start_)) continue;
      dynamic_reconfigure::Config msg;
      value->toMessage(msg, accepted_);
      all.push_back(text_of(msg));
    }
    return all;
  }

  /// Takes values that another call has put into effect, and notifies clients. To be called by the
  /// thread of the callbacks: another server's callback may hold its lock, too.
  void show(const Generated& values) {
    const boost::recursive_mutex::scoped_lock lock(mutex_);
    const auto differs = [&](const auto& value) { return accepted_.differs(*value, values); };
    const auto& all = Generated::__getParamDescriptions__();
    if (std::none_of(all.begin(), all.end(), differs)) return;
    static_cast<Generated&>(accepted_) = values;
    server_->updateConfig(accepted_);
  }

  /// Applies the start's values and notifies clients; from any thread. Throws the exceptions of
  /// `apply` without a change.
  void reset() {
    const boost::recursive_mutex::scoped_lock lock(mutex_);
    if (changed().empty()) return;
    apply_(start_);
    static_cast<Generated&>(accepted_) = start_;
    server_->updateConfig(accepted_);
  }

 private:
  std::optional<Generated> known_;
  const Generated start_;
  Config accepted_;
  std::function<void(const Generated&)> apply_;
  boost::recursive_mutex mutex_;
  std::optional<dynamic_reconfigure::Server<Config>> server_;
};

}  // namespace clothsim_ros
