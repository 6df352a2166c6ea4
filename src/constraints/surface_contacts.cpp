#include "clothsim/constraints/surface_contacts.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <mutex>

#include "clothsim/constraints/crossing_guard.h"
#include "clothsim/geometry/box_tree.h"

namespace clothsim {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Share of an overlap that the impulses work off each step. Kept impulses integrate it, so a large
/// share shakes piles.
constexpr double overlap_share = 0.01;

/// Changes that a pass leaves out, of the precision to which it solves.
constexpr double unseen_share = 0.0125;

/// Force that works off an overlap, of the weight of the cloth: more shakes layers that fingers
/// leave a little room, but not their thickness.
constexpr double parting_push = 0.1;

/// Force on what is pinched in part, of the weight of the cloth.
constexpr double next_to_pinched = 0.2;

/// Cosine of the angle by which the direction of a pair may turn in half a step.
constexpr double least_turn = 0.5;

/// Contacts from which on they have sides: below, a pass is over before another thread is there.
constexpr std::size_t least_split = 200;

/// Sum of the points, by weight.
inline Vector3 sum(const std::array<int, 4>& p, const std::array<double, 4>& weights,
                   const Points& x) {
  const auto along = [&](int axis) {
    const auto share = [&](std::size_t k) { return weights[k] * x(p[k], axis); };
    return (share(0) + share(1)) + (share(2) + share(3));
  };
  return {along(0), along(1), along(2)};
}

/// points_k += w_k / m_k d.
inline void push_apart(const Cloth& cloth, const std::array<int, 4>& points,
                       const std::array<double, 4>& weights, const Vector3& d, Points& x) {
  for (std::size_t k = 0; k < 4; ++k) {
    const double weight = weights[k] * cloth.inv_mass[points[k]];
    for (int axis = 0; axis < 3; ++axis) x(points[k], axis) += weight * d[axis];
  }
}

}  // namespace

SurfaceContacts::SurfaceContacts(const Cloth& cloth) : near_(cloth) {}

/// Does no other triangle hold the same closest points? Where they lie on edges and corners, the
/// triangle that owns these answers for them, unless it has the point itself.
bool SurfaceContacts::is_nearest_on_surface(const SurfacePair& pair, const Separation& s) const {
  if (pair.edges()) {
    return std::all_of(s.weights.begin(), s.weights.end(), [](double w) { return w != 0; });
  }
  const SurfaceMesh& mesh = near_.mesh();
  int zeros = 0;
  std::size_t zero = 0, corner = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    if (s.weights[k + 1] == 0) {
      ++zeros;
      zero = k;
    } else {
      corner = k;
    }
  }
  if (zeros == 0) return true;
  const auto triangle = static_cast<std::size_t>(pair.triangle);
  const int owner =
      zeros == 1
          ? mesh.triangle_of_edge[triangle][zero]
          : mesh.triangle_of_point[static_cast<std::size_t>(mesh.triangles[triangle][corner])];
  const auto& has = mesh.triangles[static_cast<std::size_t>(owner)];
  return owner == pair.triangle || std::find(has.begin(), has.end(), pair.points[0]) != has.end();
}

/// Of a pair that may touch within the step, or had an impulse in the last one.
std::optional<SurfaceContacts::Contact> SurfaceContacts::find(const Cloth& cloth,
                                                              const NearPair& near, bool held,
                                                              const Points& middle,
                                                              const Points& velocities) const {
  const SurfacePair& pair = near.pair;
  if (near.separation.distance == 0 || !is_nearest_on_surface(pair, near.separation)) return {};

  // Most do not get there.
  const Vector3& last_normal = near.separation.normal;
  const double way = h_ * -gap_along(last_normal, pair, velocities);
  const double room = gap_along(last_normal, pair, middle) - pair.nearest;
  if (!held && room > 0 && way < room) return {};

  // As they lie where impulses act; if they have passed through each other by then, as they lay.
  Separation s = separation(pair, middle);
  if (s.normal.dot(near.separation.normal) < least_turn) {
    s = near.separation;
    s.distance = s.normal.dot(sum(pair.points, s.weights, middle));
  }

  // The gap may close within a step. Others may yet push a touching pair together.
  const double gap = s.distance - pair.nearest;
  const double slowest = -(gap > 0 ? 1 : overlap_share) * gap / h_;
  const double rate = s.normal.dot(sum(pair.points, s.weights, velocities));
  if (!held && rate >= slowest && gap > 0) return {};

  double inv_mass = 0;
  for (std::size_t k = 0; k < 4; ++k) {
    inv_mass += s.weights[k] * s.weights[k] * cloth.inv_mass[pair.points[k]];
  }
  if (inv_mass == 0) return {};
  const double to_stop = std::abs(rate) / inv_mass;
  const double most = strongest_push_ + 2 * to_stop;
  return Contact{
      near.key,     pair.points,
      s.weights,    1 / inv_mass,
      pair.nearest, {s.normal, Vector3::Zero(), slowest, cloth.friction, most, most_to_part_}};
}

void SurfaceContacts::begin(const Cloth& cloth, const ContactStep& step, State& state) {
  const double scale = h_ > 0 ? step.h / h_ : 0;
  h_ = step.h;
  strongest_push_ = cloth.mass.sum() * step.gravity * h_;
  most_to_part_ = parting_push * strongest_push_;

  last_.swap(contacts_);
  contacts_.clear();
  const Points middle = state.positions - step.reach * h_ * step.drifted;  // where impulses act
  const auto comes_before = [](const Contact& c, std::uint64_t key) { return c.key < key; };
  // By velocities that have met contact: by those that forces gave since, all of a pile at rest
  // would be about to touch.
  const Points ahead = step.start + h_ * (step.velocities ? *step.velocities : step.drifted);
  const std::vector<NearPair>& near_pairs =
      near_.approaching(cloth, step.start, ahead, step.workers, step.budget);
  std::mutex mutex;
  std::map<int, std::vector<Contact>> found;  // by the first pair that a thread looked at
  constexpr int least = 256;
  step.workers.share(
      static_cast<int>(near_pairs.size()),
      [&](int begin, int end) {
        std::vector<Contact> contacts;
        contacts.reserve(static_cast<std::size_t>(end - begin));
        auto kept = last_.begin();
        for (int k = begin; k < end; ++k) {
          const NearPair& near = near_pairs[static_cast<std::size_t>(k)];
          if (k == begin) kept = std::lower_bound(kept, last_.end(), near.key, comes_before);
          while (kept != last_.end() && kept->key < near.key) ++kept;
          const bool held = kept != last_.end() && kept->key == near.key && kept->impulse.push > 0;
          std::optional<Contact> contact = find(cloth, near, held, middle, state.velocities);
          if (!contact) continue;
          if (held) contact->impulse.resume(kept->impulse, scale);
          contacts.push_back(*contact);
        }
        const std::lock_guard<std::mutex> lock(mutex);
        found[begin] = std::move(contacts);
      },
      least);
  for (auto& [begin, contacts] : found) {
    if (contacts_.empty()) {
      contacts_.swap(contacts);
    } else {
      contacts_.insert(contacts_.end(), contacts.begin(), contacts.end());
    }
  }
  group(middle);
  changed_.mark_all(cloth.num_points());
  for (const Contact& c : contacts_) {
    if (c.impulse.push == 0) continue;
    push_apart(cloth, c.points, c.weights, c.impulse.total(), state.velocities);
  }
}

/// Colliders alone move what they pinch. What is pinched in part, they push together: the rest
/// would have to leap to keep its distance. What a contact has already given beyond that, it takes
/// back.
void SurfaceContacts::leave_to(const Pinches& pinches, const Cloth& cloth, Points& velocities) {
  for (Contact& c : contacts_) {
    int points = 0, held = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      if (c.weights[k] == 0) continue;
      ++points;
      held += pinches.holds(c.points[k]);
    }
    if (held == 0) continue;
    const Vector3 given = c.impulse.total();
    if (held == points) {
      c.impulse.let_go();
    } else {
      c.impulse.weaken(next_to_pinched * strongest_push_);
    }
    push_apart(cloth, c.points, c.weights, c.impulse.total() - given, velocities);
  }
}

/// By the plane that has half of the contacts on either side, across the longest way they reach.
void SurfaceContacts::group(const Points& positions) {
  for (std::vector<Place>& places : groups_) places.clear();
  const std::size_t count = contacts_.size();
  int axis = 0;
  double split = -infinity;
  if (count >= least_split) {
    Box box;
    for (const Contact& c : contacts_) box.extend(row(positions, c.points[0]));
    box.sizes().maxCoeff(&axis);
    std::vector<double> along;
    for (const Contact& c : contacts_) along.push_back(positions(c.points[0], axis));
    const auto middle = along.begin() + static_cast<std::ptrdiff_t>(count / 2);
    std::nth_element(along.begin(), middle, along.end());
    split = *middle;
  }
  for (std::size_t k = 0; k < count; ++k) {
    const std::array<int, 4>& points = contacts_[k].points;
    const auto before = std::count_if(points.begin(), points.end(),
                                      [&](int i) { return positions(i, axis) < split; });
    const Group group = before == 4 ? one_side : before == 0 ? other_side : across;
    groups_[group].push_back({points, static_cast<int>(k)});
  }
}

double SurfaceContacts::sweep(const Cloth& cloth, double precision, Points& velocities,
                              const Workers& workers) {
  const double least = unseen_share * precision;  // [m]
  changed_.look(velocities, least / h_);
  std::array<double, num_groups> changes{};
  const auto sweep_groups = [&](int begin, int end) {
    for (int k = begin; k < end; ++k) {
      const auto group = static_cast<Group>(k);
      changes[group] = sweep_group(group, cloth, least, velocities);
    }
  };
  if (groups_[one_side].empty()) {
    sweep_groups(one_side, across);
  } else {
    workers.share(2, sweep_groups, 1);
  }
  sweep_groups(across, num_groups);
  return *std::max_element(changes.begin(), changes.end());
}

double SurfaceContacts::sweep_group(Group group, const Cloth& cloth, double least,
                                    Points& velocities) {
  double residual2 = 0;
  for (const Place& place : groups_[group]) {
    if (!changed_.any(place.points)) continue;
    Contact& c = contacts_[static_cast<std::size_t>(place.contact)];
    const Vector3 v = sum(c.points, c.weights, velocities);
    if (c.impulse.push == 0 && c.impulse.normal.dot(v) >= c.impulse.slowest) continue;
    const Vector3 change = c.impulse.update(v, c.mass);
    push_apart(cloth, c.points, c.weights, change, velocities);
    const double way = h_ / c.mass;  // of the points by an impulse [s/kg]
    const double change2 = way * way * change.squaredNorm();
    if (change2 > least * least) changed_.mark(c.points);
    residual2 = std::max(residual2, change2);
  }
  return std::sqrt(residual2);
}

int SurfaceContacts::guard(const Cloth& cloth, const ContactStep& step, const Points& by_impulses,
                           State& state) {
  return keep_from_crossing(cloth, step, by_impulses, near_, state);
}

void SurfaceContacts::add_impulses(double scale, Points& total) const {
  for (const Contact& c : contacts_) {
    const Vector3 impulse = scale * c.impulse.total();
    for (std::size_t k = 0; k < 4; ++k) {
      total.row(c.points[k]) += c.weights[k] * impulse.transpose();
    }
  }
}

void SurfaceContacts::for_each_touch(const Cloth&,
                                     const std::function<void(const SelfTouch&)>& visit) const {
  for (const Contact& c : contacts_) visit({c.points, c.weights, c.impulse.normal, c.nearest});
}

int SurfaceContacts::count() const {
  return static_cast<int>(std::count_if(contacts_.begin(), contacts_.end(),
                                        [](const Contact& c) { return c.impulse.push > 0; }));
}

void SurfaceContacts::reset() {
  contacts_.clear();
  for (std::vector<Place>& places : groups_) places.clear();
  h_ = 0;
}

void SurfaceContacts::write(MemoryWriter& memory) const {
  memory.add(h_);
  memory.add(count());
  for (const Contact& c : contacts_) {
    if (c.impulse.push == 0) continue;
    memory.add(static_cast<double>(c.key >> 40));
    memory.add(static_cast<double>(c.key >> 16 & 0xffffff));
    memory.add(static_cast<double>(c.key & 0xffff));
    c.impulse.write(memory);
  }
}

void SurfaceContacts::read(MemoryReader& memory, const Cloth&) {
  reset();
  h_ = std::max(0.0, memory.number());
  for (std::size_t left = memory.count(); left > 0; --left) {
    Contact c{0, {}, {}, 0, 0, {}};
    for (const int bits : {24, 24, 16}) {
      c.key = c.key << bits | static_cast<std::uint64_t>(memory.index(std::size_t{1} << bits));
    }
    c.impulse.read(memory);
    contacts_.push_back(c);
  }
}

}  // namespace clothsim
