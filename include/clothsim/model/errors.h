#pragma once

#include <stdexcept>
#include <string>
#include <vector>

namespace clothsim {

/// An invalid value from the user. `what()` reads "cloth.ks: got -5, expected a number of at least
/// 0 [N/m]".
class InvalidValue : public std::runtime_error {
 public:
  /// `key` is the path to the value, outermost first, such as {"cloth", "ks"}.
  InvalidValue(std::vector<std::string> key, std::string got, std::string expected);

  /// The message with the key in another format: `prefix`, then the path joined by `separator`. The
  /// node uses it to print the full ROS parameter name.
  std::string message(const std::string& prefix, const std::string& separator) const;

  /// The same error with `parent` put before its key: {"ks"} inside "cloth" is {"cloth", "ks"}.
  InvalidValue inside(const std::string& parent) const;

  const std::vector<std::string>& key() const { return key_; }

 private:
  std::vector<std::string> key_;
  std::string got_;
  std::string expected_;
};

/// The state is no longer finite. The simulator still holds the last good frame.
class Diverged : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A frame was interrupted on request. The simulator still holds the one before.
class Interrupted : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace clothsim
