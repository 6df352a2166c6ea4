#include "clothsim/constraints/point_contacts.h"

#include <algorithm>
#include <cmath>

namespace clothsim {
namespace {

/// Room added to the contact distance when candidates are sought, so that they serve for many
/// steps.
constexpr double skin_share = 0.5;

/// Rest distance below which a pair is left out, in contact distances.
constexpr double rest_exclusion = 2;

/// Share of an overlap that correct() takes out in a step. All of it would shake piles where the
/// springs pull back what is pushed out.
constexpr double overlap_share = 0.3;

double contact_distance(const Cloth& cloth) { return 2 * cloth.thickness; }

/// points_b += w_b d, points_a -= w_a d.
void push_apart(const Cloth& cloth, const PointPair& pair, const Vector3& d, Points& points) {
  points.row(pair.a) -= cloth.inv_mass[pair.a] * d.transpose();
  points.row(pair.b) += cloth.inv_mass[pair.b] * d.transpose();
}

}  // namespace

void PointContacts::find_candidates(const Cloth& cloth, const Points& positions, double distance,
                                    WorkBudget* budget) {
  // A common motion brings nobody closer: only what goes beyond it counts.
  if (found_at_.rows() == positions.rows()) {
    const Points moved = positions - found_at_;
    const Eigen::RowVector3d common = moved.colwise().mean();
    const double farthest2 = (moved.rowwise() - common).rowwise().squaredNorm().maxCoeff();
    if (farthest2 <= skin_ * skin_ / 4) return;
  }
  seek(cloth, positions, distance, budget);
}

void PointContacts::seek(const Cloth& cloth, const Points& positions, double distance,
                         WorkBudget* budget) {
  skin_ = skin_share * distance;
  found_at_ = positions;
  finder_.find(positions, distance + skin_, candidates_, budget);

  const double nearest = rest_exclusion * contact_distance(cloth);
  const auto neighbours_at_rest = [&](const PointPair& p) {
    const double rest2 =
        (cloth.rest_positions.row(p.a) - cloth.rest_positions.row(p.b)).squaredNorm();
    return rest2 < nearest * nearest || cloth.inv_mass[p.a] + cloth.inv_mass[p.b] == 0;
  };
  candidates_.erase(std::remove_if(candidates_.begin(), candidates_.end(), neighbours_at_rest),
                    candidates_.end());
}

void PointContacts::begin(const Cloth& cloth, const ContactStep& step, State& state) {
  const double scale = h_ > 0 ? step.h / h_ : 0;
  h_ = step.h;
  const double nearest = contact_distance(cloth);
  find_candidates(cloth, state.positions, nearest, step.budget);
  step.spend(static_cast<std::int64_t>(2 * candidates_.size()));  // with correct()

  last_.swap(contacts_);
  contacts_.clear();
  auto kept = last_.begin();
  for (const PointPair& pair : candidates_) {
    const Vector3 d = row(state.positions, pair.b) - row(state.positions, pair.a);
    const double length = d.norm();
    if (length == 0) continue;  // no direction to part in
    const Vector3 normal = d / length;

    // The gap this step would leave if the pair did not part.
    const double rate = normal.dot(row(state.velocities, pair.b) - row(state.velocities, pair.a));
    const double drift = normal.dot(row(step.drifted, pair.b) - row(step.drifted, pair.a));
    const double gap = length - nearest - step.reach * h_ * drift;
    const double slowest = -std::max(gap, 0.0) / h_;

    while (kept != last_.end() && kept->pair < pair) ++kept;
    const bool held = kept != last_.end() && kept->pair == pair && kept->impulse.push > 0;
    // Others may yet push a touching pair together.
    if (!held && rate >= slowest && gap > 0) continue;

    Contact contact{pair,
                    cloth.inv_mass[pair.a] + cloth.inv_mass[pair.b],
                    {normal, Vector3::Zero(), slowest, cloth.friction}};
    if (held) contact.impulse.resume(kept->impulse, scale);
    contacts_.push_back(contact);
  }
  for (const Contact& c : contacts_) {
    if (c.impulse.push > 0) push_apart(cloth, c.pair, c.impulse.total(), state.velocities);
  }
}

void PointContacts::leave_to(const Pinches& pinches, const Cloth& cloth, Points& velocities) {
  for (Contact& c : contacts_) {
    if (!pinches.holds(c.pair.a) || !pinches.holds(c.pair.b)) continue;
    push_apart(cloth, c.pair, -c.impulse.total(), velocities);
    c.impulse.let_go();
  }
}

double PointContacts::sweep(const Cloth& cloth, double, Points& velocities, const Workers&) {
  double residual2 = 0;
  for (Contact& c : contacts_) {
    const Vector3 v = row(velocities, c.pair.b) - row(velocities, c.pair.a);
    const Vector3 change = c.impulse.update(v, 1 / c.inv_mass);
    push_apart(cloth, c.pair, change, velocities);
    residual2 = std::max(residual2, change.squaredNorm() * c.inv_mass * c.inv_mass);
  }
  return std::sqrt(residual2) * h_;
}

void PointContacts::correct(const Cloth& cloth, Points& positions) const {
  const double nearest = contact_distance(cloth);
  for (const PointPair& pair : candidates_) {
    const Vector3 d = row(positions, pair.b) - row(positions, pair.a);
    const double length = d.norm();
    if (length >= nearest || length == 0) continue;
    const double inv_mass = cloth.inv_mass[pair.a] + cloth.inv_mass[pair.b];
    const double overlap = nearest - length;
    push_apart(cloth, pair, overlap_share * overlap / (inv_mass * length) * d, positions);
  }
}

void PointContacts::add_impulses(double scale, Points& sum) const {
  for (const Contact& c : contacts_) {
    const Vector3 impulse = scale * c.impulse.total();
    sum.row(c.pair.b) += impulse.transpose();
    sum.row(c.pair.a) -= impulse.transpose();
  }
}

void PointContacts::for_each_touch(const Cloth& cloth,
                                   const std::function<void(const SelfTouch&)>& visit) const {
  for (const Contact& c : contacts_) {
    visit({{c.pair.b, c.pair.a, c.pair.a, c.pair.a},
           {1, -1, 0, 0},
           c.impulse.normal,
           contact_distance(cloth)});
  }
}

int PointContacts::count() const {
  return static_cast<int>(std::count_if(contacts_.begin(), contacts_.end(),
                                        [](const Contact& c) { return c.impulse.push > 0; }));
}

void PointContacts::reset() {
  contacts_.clear();
  found_at_.resize(0, 3);
  h_ = 0;
}

void PointContacts::write(MemoryWriter& memory) const {
  memory.add(h_);
  memory.add(found_at_.rows() > 0);
  memory.add(found_at_);
  memory.add(count());
  for (const Contact& c : contacts_) {
    if (c.impulse.push == 0) continue;
    memory.add(c.pair.a);
    memory.add(c.pair.b);
    c.impulse.write(memory);
  }
}

void PointContacts::read(MemoryReader& memory, const Cloth& cloth) {
  reset();
  h_ = std::max(0.0, memory.number());
  if (memory.index(2) == 1) {
    seek(cloth, memory.points(cloth.num_points()), contact_distance(cloth), nullptr);
  }
  const auto points = static_cast<std::size_t>(cloth.num_points());
  for (std::size_t left = memory.count(); left > 0; --left) {
    const int a = memory.index(points);
    const int b = memory.index(points);
    Contact c{{a, b}, 0, {}};
    c.impulse.read(memory);
    contacts_.push_back(c);
  }
}

}  // namespace clothsim
