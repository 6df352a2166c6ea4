// Which springs strain_limit.cpp holds in a step, in the order of their sweeps.

#include "clothsim/constraints/strain_limit.h"

namespace clothsim {
/// Springs longer than their limit, and those an impulse still holds. False where they are those of
/// the last step.
bool StrainLimit::find_active(const Points& positions, const Workers& workers) {
  flag_longer_than(longest_, positions, workers);
  for_each_active([&](const FourSprings& s, std::size_t k, int id) {
    if (s.kick[k] > 0) {
      flags_[index(id / Piece::length)] |= std::uint64_t{1} << id % Piece::length;
    }
  });
  if (flags_ == last_flags_) return false;  // as ever at rest
  last_flags_ = flags_;

  last_touched_ = touched_;
  last_given_.swap(given_);
  last_active_.swap(active_);
  last_ids_.swap(ids_);
  clear_active();
  // Those that pulled are flagged, and come in the order of the last step.
  std::size_t next = 0;
  const auto add = [&](int id) {
    Kick kick;
    while (next < last_ids_.size()) {
      const FourSprings& s = last_active_[next / FourSprings::count];
      const std::size_t k = next % FourSprings::count;
      if (s.kick[k] > 0 && last_ids_[next] != id) break;
      if (s.kick[k] > 0) kick = {s.kick[k], s.mass[k], s.share[k], {s.x[k], s.y[k], s.z[k]}};
      ++next;
      if (s.kick[k] > 0) break;
    }
    add_active(id, kick);
  };
  for (std::size_t begin = 0, end = 0; begin < pieces_.size(); begin = end) {
    while (end < pieces_.size() && pieces_[end].direction == pieces_[begin].direction) ++end;
    for (std::size_t i = begin; i < end; ++i) for_each_bit(i, flags_[i] & ~pieces_[i].second, add);
    for (std::size_t i = begin; i < end; ++i) for_each_bit(i, flags_[i] & pieces_[i].second, add);
  }
  close_active();
  return true;
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

/// To be called in the order of colours.
void StrainLimit::add_active(int id, const Kick& kick) {
  const Constraint c = constraint(id);
  const bool new_colour = active_.empty() || c.colour != colour_;
  if (new_colour || lane_ == FourSprings::count) {
    const auto fours = static_cast<int>(active_.size());
    constexpr int segment_length = at_once / static_cast<int>(FourSprings::count);
    const int begun = segment_ends_.empty() ? 0 : segment_ends_.back();
    if (fours > begun && (new_colour || fours - begun == segment_length)) {
      segment_ends_.push_back(fours);
    }
    if (new_colour && fours > 0) colour_ends_.push_back(static_cast<int>(segment_ends_.size()));
    active_.push_back({});
    ids_.insert(ids_.end(), FourSprings::count, -1);
    lengths_.insert(lengths_.end(), FourSprings::count, 1.0);
    colour_ = c.colour;
    lane_ = 0;
  }
  FourSprings& s = active_.back();
  s.x[lane_] = kick.direction.x();
  s.y[lane_] = kick.direction.y();
  s.z[lane_] = kick.direction.z();
  s.kick[lane_] = kick.kick;
  s.mass[lane_] = kick.mass;
  s.share[lane_] = kick.share;
  s.a[lane_] = FourSprings::place(touch(c.a));
  s.b[lane_] = FourSprings::place(touch(c.b));
  const std::size_t place = ids_.size() - FourSprings::count + lane_;
  ids_[place] = id;
  lengths_[place] = longest_ * c.rest_length;
  ++lane_;
  ++num_active_;
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
  if (!active_.empty()) {
    segment_ends_.push_back(static_cast<int>(active_.size()));
    colour_ends_.push_back(static_cast<int>(segment_ends_.size()));
  }
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
