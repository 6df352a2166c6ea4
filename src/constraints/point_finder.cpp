#include "clothsim/constraints/point_finder.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace clothsim {
namespace {

/// Room added to the contact distance when candidates are sought, so that they serve for many
/// steps.
constexpr double skin_share = 0.5;

/// Rest distance below which a pair is left out, in contact distances.
constexpr double rest_exclusion = 2;

/// Share of an overlap that correct() takes out in a step. All of it would shake piles where the
/// springs pull back what is pushed out.
constexpr double parted_share = 0.3;

double contact_distance(const Cloth& cloth) { return 2 * cloth.thickness; }

std::uint64_t key_of(const PointPair& pair) {
  return static_cast<std::uint64_t>(pair.a) << 32 | static_cast<std::uint64_t>(pair.b);
}

}  // namespace

void PointFinder::find_candidates(const Cloth& cloth, const Points& positions, double distance,
                                  WorkBudget* budget) {
  // A common motion brings nobody closer: only what goes beyond it counts.
  if (found_at_.rows() == positions.rows()) {
    if (longest_beyond_mean(found_at_, positions) <= skin_ / 2) return;
  }
  seek(cloth, positions, distance, budget);
}

void PointFinder::seek(const Cloth& cloth, const Points& positions, double distance,
                       WorkBudget* budget) {
  skin_ = skin_share * distance;
  found_at_ = positions;
  const double nearest = rest_exclusion * contact_distance(cloth);
  const auto neighbours_at_rest = [&](const PointPair& p) {
    const double rest2 =
        (row(cloth.rest_positions, p.a) - row(cloth.rest_positions, p.b)).squaredNorm();
    return rest2 < nearest * nearest || cloth.inv_mass[p.a] + cloth.inv_mass[p.b] == 0;
  };
  finder_.find(positions, distance + skin_, candidates_, budget, neighbours_at_rest);
}

void PointFinder::find(const Cloth& cloth, const ContactStep& step, const State& state,
                       ContactList& list) {
  const double nearest = contact_distance(cloth);
  find_candidates(cloth, state.positions, nearest, step.budget);
  step.spend(static_cast<std::int64_t>(2 * candidates_.size()));  // with correct()

  ContactList::Last last(list, 0);
  for (const PointPair& pair : candidates_) {
    const Vector3 d = row(state.positions, pair.b) - row(state.positions, pair.a);
    const double length = d.norm();
    if (length == 0) continue;  // no direction to part in
    const Vector3 normal = d / length;

    // The gap this step would leave if the pair did not part.
    const double rate = normal.dot(row(state.velocities, pair.b) - row(state.velocities, pair.a));
    const double drift = normal.dot(row(step.drifted, pair.b) - row(step.drifted, pair.a));
    const double gap = length - nearest - step.reach * step.h * drift;
    const double slowest = -std::max(gap, 0.0) / step.h;

    const std::uint64_t key = key_of(pair);
    const Contact* const kept = last.of(key);
    // Others may yet push a touching pair together.
    if (!kept && rate >= slowest && gap > 0) continue;

    Contact contact{key, {pair.b, pair.a, pair.a, pair.a}, {1, -1, 0, 0}};
    contact.nearest = nearest;
    contact.impulse = {normal, Vector3::Zero(), slowest, cloth.friction};
    contact.weigh(cloth);
    if (kept) contact.impulse.keep(kept->impulse);
    list.add(contact);
  }
}

void PointFinder::correct(const Cloth& cloth, Points& positions) const {
  const double nearest = contact_distance(cloth);
  for (const PointPair& pair : candidates_) {
    const Vector3 d = row(positions, pair.b) - row(positions, pair.a);
    const double length = d.norm();
    if (length >= nearest || length == 0) continue;
    const double inv_mass = cloth.inv_mass[pair.a] + cloth.inv_mass[pair.b];
    const double overlap = nearest - length;
    const Vector3 apart = parted_share * overlap / (inv_mass * length) * d;
    positions.row(pair.a) -= cloth.inv_mass[pair.a] * apart.transpose();
    positions.row(pair.b) += cloth.inv_mass[pair.b] * apart.transpose();
  }
}

void PointFinder::write(MemoryWriter& memory) const {
  memory.add(found_at_.rows() > 0);
  memory.add(found_at_);
}

void PointFinder::read(MemoryReader& memory, const Cloth& cloth) {
  seek_anew();
  if (memory.index(2) == 1) {
    seek(cloth, memory.points(cloth.num_points()), contact_distance(cloth), nullptr);
  }
}

}  // namespace clothsim
