#pragma once

#include <atomic>
#include <cstdint>

namespace clothsim {

/// What may yet be done in a frame, in visits: to look once at a point, a contact or two features
/// takes some 10 ns. It is counted, not timed: the same frame ends in the same way on any machine,
/// with any number of threads.
class WorkBudget {
 public:
  // What takes so many visits, measured.
  static constexpr int contact_in_pass = 5;      // of the cloth with itself
  static constexpr int point_on_colliders = 10;  // to find and to correct its contacts
  static constexpr int patches_measured = 100;   // against each other

  /// From now on, until the next call.
  void allow(double visits) { left_ = static_cast<std::int64_t>(visits); }

  /// From any thread.
  void spend(std::int64_t visits) { left_.fetch_sub(visits, std::memory_order_relaxed); }

  /// Whoever finds it so leaves off: what it has begun will be taken back.
  bool is_spent() const { return left_.load(std::memory_order_relaxed) < 0; }

 private:
  std::atomic<std::int64_t> left_{0};
};

}  // namespace clothsim
