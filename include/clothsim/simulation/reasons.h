#pragma once

#include <set>
#include <string>

namespace clothsim {

/// Reasons for the method of a frame, and shortcomings of the frame.
enum class Reason {
  // For the choice of a method.
  named_by_scene,
  no_springs,
  error_not_predicted,
  cheapest_within_tolerance,
  most_accurate_in_real_time,
  none_in_real_time,
  none_stable,
  softens,
  // After a frame failed.
  method_failed,
  failed_before_set_state,
  // For the frame itself.
  beyond_stability,
  newton_unconverged,
  limit_yields,
  passes_unconverged,
  crosses_itself,
};

/// A set of reasons for programs, and the same in words.
class Reasons {
 public:
  Reasons() = default;
  Reasons(Reason first, const std::string& detail = {}) { add(first, detail); }

  /// Adds a reason; `detail` is appended to its clause.
  void add(Reason, const std::string& detail = {});

  bool has(Reason reason) const { return all_.count(reason) > 0; }
  const std::set<Reason>& all() const { return all_; }

  /// A sentence with a clause for each reason, in the order of add().
  const std::string& text() const { return text_; }

  /// For an archive, such as cereal's, that writes or reads its arguments.
  template <class Archive>
  void serialize(Archive& archive) {
    archive(all_, text_);
  }

 private:
  std::set<Reason> all_;
  std::string text_;
};

}  // namespace clothsim
