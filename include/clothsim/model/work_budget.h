#pragma once

#include <atomic>
#include <cstdint>

namespace clothsim {

/// Work that is left in a frame, in visits: one visit to a point, a contact or a pair of features
/// takes some 10 ns. Work is counted, not timed: the same frame ends in the same way on any
/// machine, with any number of threads.
class WorkBudget {
 public:
  // Measured costs, in visits.
  static constexpr int contact_in_pass = 5;      // of the cloth with itself
  static constexpr int point_on_colliders = 10;  // to find and to correct its contacts
  static constexpr int patches_measured = 100;   // against each other

  /// Sets the budget until the next call.
  void allow(double visits) { left_ = static_cast<std::int64_t>(visits); }

  /// May be called from any thread.
  void spend(std::int64_t visits) { left_.fetch_sub(visits, std::memory_order_relaxed); }

  /// Code that finds this true stops: its work will be undone.
  bool is_spent() const { return left_.load(std::memory_order_relaxed) < 0; }

 private:
  std::atomic<std::int64_t> left_{0};
};

}  // namespace clothsim
