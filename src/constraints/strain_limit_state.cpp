// The strain limit's state between steps: taken over, forgotten, written and read.

#include <algorithm>
#include <cassert>
#include <utility>

#include "clothsim/constraints/strain_limit.h"
#include "clothsim/model/errors.h"

namespace clothsim {

void StrainLimit::take_over(StrainLimit&& last) {
  assert(pieces_.size() == last.pieces_.size());
  std::vector<Piece> pieces = std::move(pieces_);  // with their limits
  const double least_limit = least_limit_, most_limit = most_limit_;
  inertia_.take_over(std::move(last.inertia_));
  last.inertia_ = std::move(inertia_);
  *this = std::move(last);
  pieces_ = std::move(pieces);
  least_limit_ = least_limit;
  most_limit_ = most_limit;
  for (std::size_t i = 0; i < ids_.size(); ++i) {
    if (ids_[i] < 0) continue;
    const Constraint c = constraint(ids_[i]);
    lengths_[i] = c.longest * c.rest_length;
    if (c.longest == infinity) end_impulse(i);
  }
}

void StrainLimit::reset() {
  last_flags_.clear();
  clear_active();
  close_active();
  inertia_.reset();
  step_ = {};
  yields_ = false;
  momentum_ = 1;
  wake();
}

void StrainLimit::write(MemoryWriter& memory) const {
  memory.add(step_.h);
  memory.add(yields_);
  memory.add(momentum_);
  std::size_t pulling = 0;
  for_each_active(
      [&](const FourSprings& s, std::size_t k, int) { pulling += s.velocity_impulse[k] > 0; });
  memory.add(static_cast<double>(pulling));
  for_each_active([&](const FourSprings& s, std::size_t k, int id) {
    if (s.velocity_impulse[k] <= 0) return;
    memory.add(id);
    memory.add(s.velocity_impulse[k]);
    memory.add(s.mass[k]);
    memory.add(s.share[k]);
    memory.add(Vector3(s.x[k], s.y[k], s.z[k]));
  });
  inertia_.write(memory);
}

void StrainLimit::read(MemoryReader& memory) {
  reset();
  step_.h = std::max(0.0, memory.number());
  yields_ = memory.index(2) == 1;
  momentum_ = std::max(1.0, memory.number());
  std::fill(flags_.begin(), flags_.end(), 0);
  struct Kept {
    int id = 0;
    double velocity_impulse = 0, mass = 0, share = 0;
    Vector3 direction{0, 0, 0};
  };
  std::vector<Kept> kept(memory.count());
  std::pair<int, int> last{-1, -1};  // colour and id: the order of passes
  for (Kept& k : kept) {
    k.id = memory.index(pieces_.size() * Piece::length);
    const std::pair<int, int> here{constraint(k.id).colour, k.id};
    if (k.id % Piece::length >= pieces_[index(k.id / Piece::length)].count || here <= last) {
      throw InvalidValue({"memory"}, "springs out of order", "those at their limit in order");
    }
    last = here;
    k.velocity_impulse = std::max(0.0, memory.number());
    k.mass = std::max(0.0, memory.number());
    k.share = memory.number();
    k.direction = memory.vector();
    flag(k.id);
  }
  last_ids_.clear();
  list_active();
  auto next = kept.begin();
  for (std::size_t i = 0; i < ids_.size(); ++i) {
    FourSprings& s = active_[i / FourSprings::count];
    const Kept k = ids_[i] < 0 ? Kept{} : *next++;
    const std::size_t lane = i % FourSprings::count;
    s.velocity_impulse[lane] = k.velocity_impulse;
    s.mass[lane] = k.mass;
    s.share[lane] = k.share;
    s.x[lane] = k.direction.x();
    s.y[lane] = k.direction.y();
    s.z[lane] = k.direction.z();
  }
  inertia_.read(memory);
}

}  // namespace clothsim
