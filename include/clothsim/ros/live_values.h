#pragma once

#include <dynamic_reconfigure/server.h>
#include <ros/console.h>
#include <ros/node_handle.h>

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

/// Calls `apply` and tells why it refused, with the names in namespace `ns`; empty: it did not.
std::optional<std::string> refusal(const std::function<void()>& apply, const std::string& ns);

/// The first value of a message, as "name value".
std::string text_of(const dynamic_reconfigure::Config&);

/// Values that dynamic_reconfigure changes, in the namespace of a node handle. `Generated` is the
/// class made from a .cfg file.
template <class Generated>
class LiveValues {
 public:
  /// Its functions take the place of the library's, whose names they have.
  struct Config : Generated {
    Config() = default;
    Config(const Generated& config) : Generated(config) {}

    // NOLINTBEGIN(bugprone-reserved-identifier)
    /// The limits of the .cfg are for sliders. The server would move a value beyond them to the
    /// limit without a word; `apply` is to accept or refuse it as it is.
    void __clamp__() {}

    /// Each value is a call of the master, some 1 ms that frames wait for: tells it what is new.
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

    std::optional<Generated>* known = nullptr;  // what the master has
  };

  /// Starts from `start`, whatever an earlier node left on the parameter server, and applies it.
  /// `apply` throws to refuse a request, which is logged and answered with the values that hold.
  LiveValues(const ros::NodeHandle& node, const Generated& start,
             std::function<void(const Generated&)> apply)
      : start_(start), accepted_(start), apply_(std::move(apply)), server_(mutex_, node) {
    accepted_.known = &known_;
    server_.updateConfig(accepted_);
    server_.setCallback([this, ns = node.getNamespace()](Config& config, std::uint32_t) {
      // dynamic_reconfigure would keep the values of a callback that throws.
      if (const auto why = refusal([&] { apply_(config); }, ns)) {
        ROS_ERROR("%s", why->c_str());
        config = accepted_;
      } else {
        accepted_ = config;
      }
    });
  }

  /// Of all values, below the namespace.
  static std::vector<std::string> names() {
    std::vector<std::string> all;
    for (const auto& value : Generated::__getParamDescriptions__()) all.push_back(value->name);
    return all;
  }

  /// The values that hold.
  const Generated& accepted() const { return accepted_; }

  /// Those that differ from the start's, as "name value"; from any thread.
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

  /// Applies those of the start and tells who listens; from any thread. Throws what `apply` throws
  /// and changes nothing.
  void reset() {
    const boost::recursive_mutex::scoped_lock lock(mutex_);
    if (changed().empty()) return;
    apply_(start_);
    static_cast<Generated&>(accepted_) = start_;
    server_.updateConfig(accepted_);
  }

 private:
  std::optional<Generated> known_;
  const Generated start_;
  Config accepted_;
  std::function<void(const Generated&)> apply_;
  boost::recursive_mutex mutex_;
  dynamic_reconfigure::Server<Config> server_;
};

}  // namespace clothsim_ros
