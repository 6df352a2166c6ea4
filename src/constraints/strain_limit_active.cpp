// Which springs strain_limit.cpp holds in a step, in the order of their sweeps.

#include <algorithm>

#include "clothsim/constraints/strain_limit.h"

namespace clothsim {
/// Springs longer than their limit, and those an impulse still holds. False where they are those of
/// the last step.
bool StrainLimit::find_active(const Points& positions, const Workers& workers) {
  flag_longer_than(longest_, positions, workers);
  for_each_active([&](const FourSprings& s, std::size_t k, int id) {
    if (s.kick[k] > 0) flag(id);
  });
  if (flags_ == last_flags_) return false;  // as ever at rest
  last_flags_ = flags_;

  last_touched_ = touched_;
  last_given_.swap(given_);
  last_active_.swap(active_);
  last_ids_.swap(ids_);
  list_active();
  return true;
}

/// Lists the flagged springs in fours of one colour, with the impulses of last_active_: all that
/// have some are flagged, and come in the same order.
void StrainLimit::list_active() {
  clear_active();
  std::size_t next = 0;  // in last_ids_
  for (std::size_t begin = 0, end = 0; begin < pieces_.size(); begin = end) {
    while (end < pieces_.size() && pieces_[end].direction == pieces_[begin].direction) ++end;
    for (const std::uint64_t first : {~std::uint64_t{0}, std::uint64_t{0}}) {
      const auto bits_of = [&](std::size_t i) { return flags_[i] & (pieces_[i].second ^ first); };
      int count = 0;
      for (std::size_t i = begin; i < end; ++i) count += __builtin_popcountll(bits_of(i));
      std::size_t place = add_colour(count);
      for (std::size_t i = begin; i < end; ++i) {
        for_each_bit(i, bits_of(i), [&](int id) { list(id, place++, next); });
      }
    }
  }
  close_active();
}

/// Makes room for `count` springs of a colour. Returns the place of the first in ids_.
std::size_t StrainLimit::add_colour(int count) {
  const std::size_t place = ids_.size();
  if (count == 0) return place;
  num_active_ += index(count);
  constexpr std::size_t segment_length = near_at_once / FourSprings::count;
  std::size_t end = active_.size();
  active_.resize(end + (index(count) + FourSprings::count - 1) / FourSprings::count);
  ids_.resize(FourSprings::count * active_.size(), -1);
  lengths_.resize(ids_.size(), 1.0);
  while (end < active_.size()) {
    end = std::min(end + segment_length, active_.size());
    segment_ends_.push_back(static_cast<int>(end));
  }
  colour_ends_.push_back(static_cast<int>(segment_ends_.size()));
  return place;
}

/// Puts a spring into its place in ids_; `next`: where in last_ids_ it is, or later ones.
void StrainLimit::list(int id, std::size_t place, std::size_t& next) {
  constexpr std::size_t fours = FourSprings::count;
  const auto pulled = [&] { return last_active_[next / fours].kick[next % fours] > 0; };
  while (next < last_ids_.size() && !pulled()) ++next;
  FourSprings& s = active_[place / fours];
  const std::size_t k = place % fours;
  if (next < last_ids_.size() && last_ids_[next] == id) {
    const FourSprings& last = last_active_[next / fours];
    const std::size_t l = next++ % fours;
    s.x[k] = last.x[l];
    s.y[k] = last.y[l];
    s.z[k] = last.z[l];
    s.kick[k] = last.kick[l];
    s.mass[k] = last.mass[l];
    s.share[k] = last.share[l];
  }
  const Constraint c = constraint(id);
  s.a[k] = FourSprings::place(touch(c.a));
  s.b[k] = FourSprings::place(touch(c.b));
  ids_[place] = id;
  lengths_[place] = longest_ * c.rest_length;
}

void StrainLimit::clear_active() {
  for (const int point : touched_) local_[index(point)] = -1;
  touched_.clear();
  active_.clear();
  ids_.clear();
  lengths_.clear();
  segment_ends_.clear();
  colour_ends_.clear();
  num_active_ = 0;
}

/// Place of a point in touched_.
int StrainLimit::touch(int point) {
  int& place = local_[index(point)];
  if (place < 0) {
    place = static_cast<int>(touched_.size());
    touched_.push_back(point);
  }
  return place;
}

void StrainLimit::close_active() {
  const std::size_t nobody = touched_.size();
  for (std::size_t i = 0; i < ids_.size(); ++i) {
    if (ids_[i] >= 0) continue;
    FourSprings& s = active_[i / FourSprings::count];
    const std::size_t lane = i % FourSprings::count;
    s.a[lane] = s.b[lane] = FourSprings::place(static_cast<int>(nobody));
  }
  for (std::vector<Quad>* quads : {&positions_, &predicted_, &velocities_, &last_, &given_}) {
    quads->resize(nobody + 1);
    quads->back() = {};
  }
}

}  // namespace clothsim
