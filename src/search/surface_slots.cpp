#include "clothsim/search/surface_slots.h"

#include <algorithm>
#include <utility>

#include "clothsim/geometry/closest_points.h"
#include "clothsim/geometry/distances.h"

namespace clothsim {
namespace {

/// What is nearer by less, of the nearest that may come, is as near.
constexpr double as_near = 1e-9;

/// Single precision tells so much, likewise.
constexpr double told = 1e-4;

}  // namespace

SurfaceSlots::SurfaceSlots(std::shared_ptr<const SurfaceMesh> mesh,
                           std::shared_ptr<const NearestDistances> nearest)
    : mesh_(std::move(mesh)), nearest_(std::move(nearest)) {
  index();
}

bool SurfaceSlots::has(int triangle, int point) const {
  const auto& [a, b, c] = corners(triangle);
  return a == point || b == point || c == point;
}

SurfacePair SurfaceSlots::pair(const Slot& slot) const {
  const auto& [a, b, c] = corners(slot.triangle);
  return {slot.triangle, {slot.point, a, b, c}, slot.nearest};
}

/// Triangles beside a slot's that hold its closest place, too: beyond an edge, around a corner.
template <typename Visit>
void SurfaceSlots::for_each_beside(const Slot& slot, const std::array<double, 3>& weights,
                                   const Visit& visit) const {
  const auto zeros = std::count(weights.begin(), weights.end(), 0.0);
  for (std::size_t k = 0; zeros > 0 && k < 3; ++k) {
    if (zeros == 1 && weights[k] == 0) {
      const int t = mesh_->across[static_cast<std::size_t>(slot.triangle)][k];
      if (t != SurfaceMesh::none && !has(t, slot.point)) visit(t);
    } else if (zeros == 2 && weights[k] != 0) {
      const int corner = corners(slot.triangle)[k];
      for (const int t : mesh_->around_point[static_cast<std::size_t>(corner)]) {
        if (t != slot.triangle && !has(t, slot.point)) visit(t);
      }
    }
  }
}

/// Where its point is closest to its triangle, as weights of the corners.
std::array<double, 3> SurfaceSlots::measure(Slot& slot, const Points& positions) const {
  const std::array<int, 3>& of = corners(slot.triangle);
  const Vector3 p = row(positions, slot.point), a = row(positions, of[0]),
                b = row(positions, of[1]), c = row(positions, of[2]);
  const auto weights = closest_on_triangle(p, a, b, c);
  slot.distance = (p - weights[0] * a - weights[1] * b - weights[2] * c).norm();
  slot.nearest = nearest_->of(pair(slot));
  return weights;
}

/// From triangle to triangle beside it, as long as these are nearer.
void SurfaceSlots::go_to_nearest(Slot& slot, const Points& positions) const {
  std::array<double, 3> weights = measure(slot, positions);
  for (bool goes = true; goes;) {
    goes = false;
    const Slot here = slot;
    const std::array<double, 3> of_here = weights;
    for_each_beside(here, of_here, [&](int t) {
      Slot there = here;
      there.triangle = t;
      const std::array<double, 3> of_there = measure(there, positions);
      if (there.gap() >= slot.gap() - as_near * slot.nearest) return;
      slot = there;
      weights = of_there;
      goes = true;
    });
  }
  slot.owner = slot.triangle;
  for_each_beside(slot, weights, [&](int t) { slot.owner = std::min(slot.owner, t); });
}

/// Is none of these, of the same point, at the same place, and as far off?
bool SurfaceSlots::is_new(const Slot& slot, const Slot* begin, const Slot* end) const {
  return std::none_of(begin, end, [&](const Slot& other) {
    return other.triangle != SurfaceMesh::none && other.owner == slot.owner &&
           other.nearest >= slot.nearest;
  });
}

void SurfaceSlots::walk(const Points& positions, const Workers& workers) {
  workers.share(
      static_cast<int>(slots_.size()),
      [&](int first, int last) {
        Distances distances;
        for (int k = first; k < last; k += static_cast<int>(Distances::capacity)) {
          const int count = std::min(last - k, static_cast<int>(Distances::capacity));
          distances.clear();
          Slot* const slots = slots_.data() + k;
          for (int i = 0; i < count; ++i) distances.add(pair(slots[i]).points);
          distances.measure(positions);
          for (int i = 0; i < count; ++i) {
            const auto place = static_cast<std::size_t>(i);
            Slot& slot = slots[i];
            slot.distance = distances[place];
            if (!distances.at_edge(place)) {
              slot.owner = slot.triangle;
            } else {
              go_to_nearest(slot, positions);
            }
          }
        }
      },
      static_cast<int>(Distances::capacity));

  bool any_ended = false;
  for (Slot& slot : slots_) {
    const bool is_far = slot.distance > reach * slot.nearest;
    if (is_far || !is_new(slot, slots_.data() + begin(slot.point), &slot)) {
      slot.triangle = SurfaceMesh::none;
      any_ended = true;
    }
  }
  if (!any_ended) return;
  const auto has_ended = [](const Slot& slot) { return slot.triangle == SurfaceMesh::none; };
  slots_.erase(std::remove_if(slots_.begin(), slots_.end(), has_ended), slots_.end());
  index();
}

bool SurfaceSlots::covers(const Proposal& proposal, double distance, double nearest) const {
  return std::any_of(
      slots_.data() + begin(proposal.point), slots_.data() + end(proposal.point),
      [&](const Slot& slot) {
        if (slot.triangle == proposal.triangle) return true;
        // A neighbour on the cloth that may come nearer does not keep off what may not.
        const double rounding = told * nearest;
        if (slot.nearest < nearest - rounding || slot.gap() > distance - nearest + rounding) {
          return false;
        }
        const auto& of = corners(slot.triangle);
        return std::any_of(of.begin(), of.end(),
                           [&](int point) { return has(proposal.triangle, point); });
      });
}

void SurfaceSlots::add(std::vector<Proposal>& proposals, const Points& positions) {
  std::sort(proposals.begin(), proposals.end());
  std::vector<Slot> added;
  std::size_t of_point = 0;  // the first added for the same point
  for (const Proposal& proposal : proposals) {
    Slot slot{proposal.point, 0, proposal.triangle, proposal.triangle};
    go_to_nearest(slot, positions);
    if (added.empty() || added.back().point != slot.point) of_point = added.size();
    const Slot* const first = slots_.data() + begin(slot.point);
    const Slot* const last = slots_.data() + end(slot.point);
    const Slot *const new_first = added.data() + of_point, *const new_last =
                                                               added.data() + added.size();
    if (slot.distance > reach * slot.nearest || !is_new(slot, first, last) ||
        !is_new(slot, new_first, new_last)) {
      continue;
    }
    const auto is_taken = [&](const Slot& other) { return other.number == slot.number; };
    while (std::any_of(first, last, is_taken) || std::any_of(new_first, new_last, is_taken)) {
      ++slot.number;
    }
    added.push_back(slot);
  }
  if (added.empty()) return;
  const auto before = [](const Slot& a, const Slot& b) {
    return a.point < b.point || (a.point == b.point && a.number < b.number);
  };
  std::sort(added.begin(), added.end(), before);
  const auto count = static_cast<std::ptrdiff_t>(slots_.size());
  slots_.insert(slots_.end(), added.begin(), added.end());
  std::inplace_merge(slots_.begin(), slots_.begin() + count, slots_.end(), before);
  index();
}

void SurfaceSlots::index() {
  first_.assign(mesh_->around_point.size() + 1, slots_.size());
  for (std::size_t k = slots_.size(); k-- > 0;)
    first_[static_cast<std::size_t>(slots_[k].point)] = k;
  for (std::size_t i = first_.size() - 1; i-- > 0;) first_[i] = std::min(first_[i], first_[i + 1]);
}

void SurfaceSlots::clear() {
  slots_.clear();
  index();
}

void SurfaceSlots::write(MemoryWriter& memory) const {
  memory.add(static_cast<double>(slots_.size()));
  for (const Slot& slot : slots_) {
    memory.add(slot.point);
    memory.add(slot.number);
    memory.add(slot.triangle);
  }
}

void SurfaceSlots::read(MemoryReader& memory) {
  slots_.clear();
  for (std::size_t left = memory.count(); left > 0; --left) {
    Slot slot{};
    slot.point = memory.index(mesh_->around_point.size());
    slot.number = memory.index(mesh_->triangles.size());
    slot.triangle = memory.index(mesh_->triangles.size());
    slot.owner = slot.triangle;
    slot.nearest = nearest_->of(pair(slot));
    slots_.push_back(slot);
  }
  index();
}

}  // namespace clothsim
