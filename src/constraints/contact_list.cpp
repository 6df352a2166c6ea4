#include "clothsim/constraints/contact_list.h"

#include <algorithm>
#include <cmath>

#include "clothsim/model/errors.h"

namespace clothsim {
namespace {

/// Changes that a pass skips, of the tolerance to which it solves.
constexpr double unseen_share = 0.0125;

/// Least width of a slab, of the mean length of its contacts.
constexpr double slab_width = 4;

/// One in so many contacts is sampled for the places of the planes.
enum { samples_apart = 8 };

/// Contacts of which a thread takes the sums at once.
constexpr std::size_t block = 256;

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
  return next_ != end_ && next_->key == key && next_->impulse.normal_impulse > 0 ? &*next_
                                                                                 : nullptr;
}

void ContactList::add(const std::vector<Contact>& contacts) {
  contacts_.insert(contacts_.end(), contacts.begin(), contacts.end());
}

void ContactList::warm_start(const Points& positions, Points& velocities, const Workers& workers) {
  group(positions, workers);
  warm_start(scale_, velocities);
}

void ContactList::warm_start(double scale, Points& velocities) {
  if (contacts_.empty()) return;
  changed_.mark_all(static_cast<int>(velocities.rows()));
  for (Contact& c : contacts_) {
    if (c.impulse.normal_impulse == 0) continue;
    c.impulse.warm_start(scale);
    c.give(c.impulse.total(), velocities);
  }
}

/// The box around all contacts, and the sum of their extents. Sums are by block, so they do not
/// depend on threads.
ContactList::Extent ContactList::extent(const Points& positions, const Workers& workers) const {
  const std::size_t count = contacts_.size();
  std::vector<Extent> blocks((count + block - 1) / block);
  workers.parallel_for(
      static_cast<int>(blocks.size()),
      [&](int begin, int end) {
        const std::size_t last = std::min(static_cast<std::size_t>(end) * block, count);
        for (std::size_t k = static_cast<std::size_t>(begin) * block; k < last; ++k) {
          Eigen::AlignedBox3d of_contact;
          for (const int point : contacts_[k].points) of_contact.extend(row(positions, point));
          blocks[k / block].lengths += of_contact.sizes();
          blocks[k / block].box.extend(of_contact);
        }
      },
      1);
  Extent all;
  for (const Extent& of_block : blocks) {
    all.lengths += of_block.lengths;
    all.box.extend(of_block.box);
  }
  return all;
}

/// Slabs of equally many contacts across the longest extent: enough of them that a pass over one
/// outlasts the start of a thread, and wide enough that most contacts lie within one.
ContactList::Cut ContactList::cut_into_slabs(const Points& positions,
                                             const Workers& workers) const {
  Cut cut;
  const std::size_t count = contacts_.size();
  if (count < 2 * std::size_t{Workers::dear}) return cut;
  const Extent all = extent(positions, workers);
  all.box.sizes().maxCoeff(&cut.axis);
  const double length = all.lengths[cut.axis] / static_cast<double>(count);
  const auto slabs =
      static_cast<std::size_t>(std::min(static_cast<double>(count / std::size_t{Workers::dear}),
                                        all.box.sizes()[cut.axis] / (slab_width * length)));
  std::vector<double> along;
  for (std::size_t k = 0; k < count; k += samples_apart) {
    along.push_back(positions(contacts_[k].points[0], cut.axis));
  }
  std::sort(along.begin(), along.end());
  for (std::size_t k = 1; k < slabs; ++k) cut.at.push_back(along[k * along.size() / slabs]);
  return cut;
}

void ContactList::group(const Points& positions, const Workers& workers) {
  const Cut cut = cut_into_slabs(positions, workers);
  const int planes = static_cast<int>(cut.at.size()), slabs = planes + 1;
  const int last_group = slabs + planes;
  stages_ = {0, slabs, slabs + slabs / 2, last_group, last_group + 1};
  for (int& end : stages_) end += ChangedPoints::parts(static_cast<int>(positions.rows()));
  group_of_.resize(contacts_.size());
  workers.each(static_cast<int>(contacts_.size()), [&](int k) {
    int first = slabs, last = 0;
    for (const int point : contacts_[static_cast<std::size_t>(k)].points) {
      const auto above = std::upper_bound(cut.at.begin(), cut.at.end(), positions(point, cut.axis));
      const int slab = static_cast<int>(above - cut.at.begin());
      first = std::min(first, slab);
      last = std::max(last, slab);
    }
    const int across = slabs + first / 2 + first % 2 * (slabs / 2);
    group_of_[static_cast<std::size_t>(k)] = last == first       ? first
                                             : last == first + 1 ? across
                                                                 : last_group;
  });
  groups_.resize(static_cast<std::size_t>(last_group) + 1);
  for (std::vector<Place>& places : groups_) places.clear();
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    groups_[static_cast<std::size_t>(group_of_[k])].push_back(
        {contacts_[k].points, static_cast<int>(k)});
  }
}

void ContactList::add_velocities(Points& sum) const {
  for (const Contact& c : contacts_) {
    if (c.impulse.normal_impulse > 0) c.give(c.impulse.total(), sum);
  }
}

double ContactList::solve_pass(double tolerance, Points& velocities, const Workers& workers) {
  if (contacts_.empty()) return 0;
  const double min_change = unseen_share * tolerance;
  changes_.assign(groups_.size(), 0);
  const int looks = stages_.front();
  workers.in_stages(stages_, [&](int part) {
    if (part < looks) return changed_.look(part, velocities, min_change);
    const auto group = static_cast<std::size_t>(part - looks);
    changes_[group] = solve_group(groups_[group], min_change, velocities);
  });
  return *std::max_element(changes_.begin(), changes_.end());
}

double ContactList::solve_group(const std::vector<Place>& places, double min_change,
                                Points& velocities) {
  double residual2 = 0;
  for (const Place& place : places) {
    if (!changed_.any(place.points)) continue;
    Contact& c = contacts_[static_cast<std::size_t>(place.contact)];
    const Vector3 v = weighted_sum(c.points, c.weights, velocities);
    if (c.impulse.normal_impulse == 0 && c.impulse.normal.dot(v) >= c.impulse.target_velocity) {
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

void ContactList::release_pinched(const Pinches& pinches, double strongest, Points& velocities) {
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
      c.impulse.deactivate();
    } else {
      c.impulse.limit_normal_impulse(strongest);
    }
    c.give(c.impulse.total() - given, velocities);
  }
}

int ContactList::count() const {
  return static_cast<int>(std::count_if(contacts_.begin(), contacts_.end(), [](const Contact& c) {
    return c.impulse.normal_impulse > 0;
  }));
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
    if (c.impulse.normal_impulse == 0) continue;
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
