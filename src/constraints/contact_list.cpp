#include "clothsim/constraints/contact_list.h"

#include <algorithm>
#include <cmath>

#include "clothsim/model/errors.h"

namespace clothsim {
namespace {

/// Changes that a pass skips, of the precision to which it solves.
constexpr double unseen_share = 0.0125;

/// Least width of a slab, of the mean length of its contacts.
constexpr double slab_width = 4;

/// One in so many contacts is sampled for the places of the planes.
enum { samples_apart = 8 };

/// A key in the memory: so many numbers of so many bits, exact.
enum { key_bits = 16, key_parts = 4 };

}  // namespace

void Contact::set_mass() {
  double inv_mass = 0;
  for (std::size_t k = 0; k < 4; ++k) inv_mass += weights[k] * moves[k];
  mass = inv_mass > 0 ? 1 / inv_mass : 0;
}

void Contact::compute_effective_mass(const Cloth& cloth) {
  for (std::size_t k = 0; k < 4; ++k) moves[k] = weights[k] * cloth.inv_mass[points[k]];
  set_mass();
}

void Contact::hold(std::size_t k) {
  moves[k] = 0;
  set_mass();
}

void Contact::give(const Vector3& given, Points& velocities) const {
  for (std::size_t k = 0; k < 4; ++k) {
    for (int axis = 0; axis < 3; ++axis) velocities(points[k], axis) += moves[k] * given[axis];
  }
}

void ContactList::start_over(double h) {
  scale_ = h_ > 0 ? h / h_ : 0;
  h_ = h;
  last_.swap(contacts_);
  contacts_.clear();
}

ContactList::Last::Last(const ContactList& list, std::uint64_t first)
    : next_(std::lower_bound(list.last_.begin(), list.last_.end(), first,
                             [](const Contact& c, std::uint64_t key) { return c.key < key; })),
      end_(list.last_.end()) {}

const Contact* ContactList::Last::of(std::uint64_t key) {
  while (next_ != end_ && next_->key < key) ++next_;
  return next_ != end_ && next_->key == key && next_->impulse.acts() ? &*next_ : nullptr;
}

void ContactList::add(const std::vector<Contact>& contacts) {
  contacts_.insert(contacts_.end(), contacts.begin(), contacts.end());
}

void ContactList::warm_start(const Points& positions, Points& velocities) {
  group(positions);
  warm_start(scale_, velocities);
}

void ContactList::warm_start(double scale, Points& velocities) {
  if (contacts_.empty()) return;
  changed_.mark_all(static_cast<int>(velocities.rows()));
  for (Contact& c : contacts_) {
    if (c.impulse.friction_impulse.isZero(0) && c.impulse.normal_impulse == 0) continue;
    c.impulse.warm_start(scale);
    c.give(c.impulse.total(), velocities);
  }
}

/// Slabs of equally many contacts across the longest extent: enough of them that a pass over one
/// outlasts the start of a thread, and wide enough that most contacts lie within one.
ContactList::Cut ContactList::cut_into_slabs(const Points& positions) const {
  Cut cut;
  const std::size_t count = contacts_.size();
  if (count < 2 * std::size_t{Workers::dear}) return cut;
  Eigen::AlignedBox3d box;
  Vector3 lengths(0, 0, 0);
  for (const Contact& c : contacts_) {
    Eigen::AlignedBox3d of_contact;
    for (const int point : c.points) of_contact.extend(row(positions, point));
    lengths += of_contact.sizes();
    box.extend(of_contact);
  }
  box.sizes().maxCoeff(&cut.axis);
  const double length = lengths[cut.axis] / static_cast<double>(count);
  const auto slabs =
      static_cast<std::size_t>(std::min(static_cast<double>(count / std::size_t{Workers::dear}),
                                        box.sizes()[cut.axis] / (slab_width * length)));
  std::vector<double> along;
  for (std::size_t k = 0; k < count; k += samples_apart) {
    along.push_back(positions(contacts_[k].points[0], cut.axis));
  }
  std::sort(along.begin(), along.end());
  for (std::size_t k = 1; k < slabs; ++k) cut.at.push_back(along[k * along.size() / slabs]);
  return cut;
}

void ContactList::group(const Points& positions) {
  const Cut cut = cut_into_slabs(positions);
  const int planes = static_cast<int>(cut.at.size()), slabs = planes + 1;
  stages_ = {slabs, slabs + slabs / 2, slabs + planes, slabs + planes + 1};
  groups_.resize(static_cast<std::size_t>(stages_.back()));
  for (std::vector<Place>& places : groups_) places.clear();
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    const std::array<int, 4>& points = contacts_[k].points;
    int first = slabs, last = 0;
    for (const int point : points) {
      const auto above = std::upper_bound(cut.at.begin(), cut.at.end(), positions(point, cut.axis));
      const int slab = static_cast<int>(above - cut.at.begin());
      first = std::min(first, slab);
      last = std::max(last, slab);
    }
    const int across = slabs + first / 2 + first % 2 * (slabs / 2);
    const int group = last == first ? first : last == first + 1 ? across : stages_.back() - 1;
    groups_[static_cast<std::size_t>(group)].push_back({points, static_cast<int>(k)});
  }
}

double ContactList::solve_pass(double precision, Points& velocities, const Workers& workers) {
  if (contacts_.empty()) return 0;
  const double min_change = unseen_share * precision;
  changed_.look(velocities, min_change, workers);
  changes_.assign(groups_.size(), 0);
  int first = 0;
  for (const int end : stages_) {
    const auto solve_groups = [&](int from, int to) {
      for (int k = first + from; k < first + to; ++k) {
        const auto group = static_cast<std::size_t>(k);
        changes_[group] = solve_group(groups_[group], min_change, velocities);
      }
    };
    workers.parallel_for(end - first, solve_groups, 1, Workers::uneven);
    first = end;
  }
  return *std::max_element(changes_.begin(), changes_.end());
}

double ContactList::solve_group(const std::vector<Place>& places, double min_change,
                                Points& velocities) {
  double residual2 = 0;
  for (const Place& place : places) {
    if (!changed_.any(place.points)) continue;
    Contact& c = contacts_[static_cast<std::size_t>(place.contact)];
    const Vector3 v = weighted_sum(c.points, c.weights, velocities);
    if (!c.impulse.acts() && c.impulse.normal.dot(v) >= c.impulse.target_velocity) {
      continue;
    }
    if (c.mass == 0) continue;
    const Vector3 change = c.impulse.update(v, c.mass);
    c.give(change, velocities);
    const double change2 = change.squaredNorm(), mass2 = c.mass * c.mass;
    if (change2 > min_change * min_change * mass2) changed_.mark(c.points);
    if (change2 > residual2 * mass2) residual2 = change2 / mass2;
  }
  return std::sqrt(residual2);
}

void ContactList::release_pinched(Pinches& pinches, double strongest, Points& velocities) {
  const auto count = [&](const Contact& c, const auto& is_counted) {
    int result = 0;
    for (std::size_t k = 0; k < 4; ++k) result += c.weights[k] != 0 && is_counted(c.points[k]);
    return result;
  };
  std::vector<Contact*> squeezed;
  for (Contact& c : contacts_) {
    const int held = count(c, [&](int point) { return pinches.holds(point); });
    if (held == 0) continue;
    if (held == count(c, [](int) { return true; })) {
      pinches.add_layer_contact(c.points, c.weights, c.impulse.normal);
      squeezed.push_back(&c);
      continue;
    }
    const Vector3 given = c.impulse.total();
    c.impulse.weaken(strongest);
    c.give(c.impulse.total() - given, velocities);
  }
  for (Contact* c : squeezed) {
    const Vector3 given = c->impulse.total();
    c->impulse.leave_normal_to(
        pinches.layer_normal_impulse(c->points, c->weights, c->impulse.normal));
    c->give(c->impulse.total() - given, velocities);
  }
}

int ContactList::count() const {
  return static_cast<int>(std::count_if(contacts_.begin(), contacts_.end(),
                                        [](const Contact& c) { return c.impulse.acts(); }));
}

void ContactList::reset() {
  contacts_.clear();
  for (std::vector<Place>& places : groups_) places.clear();
  h_ = 0;
}

void ContactList::write(MemoryWriter& memory) const {
  memory.add(h_);
  memory.add(count());
  for (const Contact& c : contacts_) {
    if (!c.impulse.acts()) continue;
    std::uint64_t rest = c.key;
    for (int k = 0; k < key_parts; ++k) {
      memory.add(static_cast<double>(rest >> (64 - key_bits)));
      rest <<= key_bits;
    }
    c.impulse.write(memory);
  }
}

void ContactList::read(MemoryReader& memory) {
  reset();
  h_ = std::max(0.0, memory.number());
  for (std::size_t left = memory.count(); left > 0; --left) {
    Contact c;
    for (int k = 0; k < key_parts; ++k) {
      c.key =
          c.key << key_bits | static_cast<std::uint64_t>(memory.index(std::size_t{1} << key_bits));
    }
    if (!contacts_.empty() && c.key <= contacts_.back().key) {
      throw InvalidValue({"memory"}, "contacts in another order", "the memory of this cloth");
    }
    c.impulse.read(memory);
    contacts_.push_back(c);
  }
}

}  // namespace clothsim
