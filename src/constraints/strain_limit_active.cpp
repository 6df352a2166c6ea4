// The springs that strain_limit.cpp holds in a step, in the order of its passes.

#include <algorithm>

#include "clothsim/constraints/strain_limit.h"

namespace clothsim {
namespace {

/// Fours of a segment: half as many as pay for a loop of their own, since a pass is one loop.
constexpr int segment_length = near_at_once / 2 / static_cast<int>(FourSprings::count);

}  // namespace

/// Finds springs longer than their limit, and those that an impulse still holds. Returns false
/// where they are those of the last step.
bool StrainLimit::find_active(const Points& positions, const Workers& workers) {
  flag_beyond_limit_by(0, positions, workers);
  for (std::size_t i = 0; i < ids_.size(); ++i) {
    if (velocity_impulses_[i] > 0) flag(ids_[i]);
  }
  if (flags_ == last_flags_) return false;  // usual at rest
  last_flags_ = flags_;

  last_touched_ = touched_;
  last_given_.swap(given_);
  last_velocity_impulses_.swap(velocity_impulses_);
  last_masses_.swap(masses_);
  last_ids_.swap(ids_);
  list_active();
  return true;
}

/// Lists the flagged springs in fours of one colour, with the impulses of last_ids_: all springs
/// with an impulse are flagged, and come in the same order.
void StrainLimit::list_active() {
  clear_active();
  std::size_t next = 0;  // in last_ids_
  for (std::size_t begin = 0, end = 0; begin < pieces_.size(); begin = end) {
    while (end < pieces_.size() && pieces_[end].direction == pieces_[begin].direction) ++end;
    for (const std::uint64_t first : {~std::uint64_t{0}, std::uint64_t{0}}) {
      for (std::size_t i = begin; i < end; ++i) {
        const Piece& piece = pieces_[i];
        for_each_bit(i, flags_[i] & (piece.second ^ first), [&](int id) { list(id, piece, next); });
      }
      close_colour();
    }
  }
  close_active();
}

/// Lists a spring; `next`: its place in last_ids_, or that of a later one.
void StrainLimit::list(int id, const Piece& piece, std::size_t& next) {
  while (next < last_ids_.size() && last_velocity_impulses_[next] == 0) ++next;
  const bool pulled = next < last_ids_.size() && last_ids_[next] == id;
  const std::size_t k = ids_.size() % FourSprings::count;
  if (k == 0 && active_.size() == fours()) active_.emplace_back();
  FourSprings& s = active_[fours()];
  const int a = piece.first + id % Piece::length;
  s.a[k] = FourSprings::place(touch(a));
  s.b[k] = FourSprings::place(touch(a + piece.offset));
  ids_.push_back(id);
  lengths_.push_back(piece.longest * piece.rest_length);
  velocity_impulses_.push_back(pulled ? last_velocity_impulses_[next] : 0);
  masses_.push_back(pulled ? last_masses_[next++] : 0);
  ++num_active_;
}

/// Fills up the last four of a colour, and divides it into segments.
void StrainLimit::close_colour() {
  while (ids_.size() % FourSprings::count != 0) {
    ids_.push_back(-1);
    lengths_.push_back(1);
    velocity_impulses_.push_back(0);
    masses_.push_back(0);
  }
  int begin = segment_ends_.empty() ? 0 : segment_ends_.back();
  for (const auto end = static_cast<int>(fours()); begin < end;) {
    segment_ends_.push_back(begin = std::min(begin + segment_length, end));
  }
  const auto end = static_cast<int>(segment_ends_.size());
  if (end > (colour_ends_.empty() ? 0 : colour_ends_.back())) colour_ends_.push_back(end);
}

void StrainLimit::clear_active() {
  for (const int point : touched_) local_[index(point)] = -1;
  touched_.clear();
  ids_.clear();
  lengths_.clear();
  velocity_impulses_.clear();
  masses_.clear();
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
  for (std::vector<Quad>* quads : {&positions_, &warm_started_, &velocities_, &last_, &given_}) {
    quads->resize(nobody + 1);
    quads->back() = {};
  }
  list_stages();
}

void StrainLimit::list_stages() {
  const auto points = static_cast<int>(touched_.size());
  stages_forth_ = {(points + points_at_once - 1) / points_at_once};
  for (const int end : colour_ends_) stages_forth_.push_back(stages_forth_.front() + end);
  stages_back_ = stages_forth_;
  for (std::size_t colour = colour_ends_.size(); colour-- > 1;) {
    stages_back_.push_back(stages_back_.back() + stages_forth_[colour] - stages_forth_[colour - 1]);
  }
}

void StrainLimit::leave_to_holders(const std::vector<int>& holder_of_point) {
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    const Piece& piece = pieces_[i];
    limited_[i] = 0;
    for (int k = 0; k < piece.count; ++k) {
      const int a = holder_of_point[index(piece.first + k)];
      const int b = holder_of_point[index(piece.first + k + piece.offset)];
      limited_[i] |= std::uint64_t{a < 0 || a != b} << k;
    }
  }
  for (std::size_t i = 0; i < ids_.size(); ++i) {
    if (ids_[i] >= 0 && !is_limited(ids_[i])) end_impulse(i);
  }
  wake();
}

void StrainLimit::add_impulse_magnitudes(const Scalars& scale, std::vector<double>& sum) const {
  std::vector<std::size_t> first;  // spring of each piece
  std::size_t springs = 0;
  for (const Piece& piece : pieces_) {
    first.push_back(springs);
    springs += index(piece.count);
  }
  for_each_active([&](const FourSprings& s, std::size_t k, int id) {
    const std::size_t spring = first[index(id / Piece::length)] + index(id % Piece::length);
    sum[spring] += scale[constraint(id).a] * s.mass[k] * s.velocity_impulse[k];
  });
}

}  // namespace clothsim
