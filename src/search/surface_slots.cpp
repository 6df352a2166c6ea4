#include "clothsim/search/surface_slots.h"

#include <algorithm>
#include <utility>

namespace clothsim {

SurfaceSlots::SurfaceSlots(std::shared_ptr<const SurfaceMesh> mesh,
                           std::shared_ptr<const NearestDistances> nearest)
    : mesh_(std::move(mesh)), nearest_(std::move(nearest)), slots_(mesh_->around_point.size()) {}

bool SurfaceSlots::has(int triangle, int point) const {
  const auto& [a, b, c] = corners(triangle);
  return a == point || b == point || c == point;
}

SurfacePair SurfaceSlots::pair(const Slot& slot) const {
  const auto& [a, b, c] = corners(slot.triangle);
  return {slot.triangle, {slot.point, a, b, c}, slot.nearest};
}

double SurfaceSlots::nearest_of(const Slot& slot) const {
  return nearest_->of(slot.point, corners(slot.triangle)[0],
                      static_cast<std::size_t>(slot.triangle % 2));
}

/// Triangles beside a slot's that hold its closest place, too: beyond an edge, around a corner.
template <typename Visit>
void SurfaceSlots::for_each_beside(const Slot& slot, const Visit& visit) const {
  const std::array<double, 4>& weights = slot.last.weights;  // of the corners behind the point's
  const auto zeros = std::count(weights.begin() + 1, weights.end(), 0.0);
  for (std::size_t k = 0; zeros > 0 && k < 3; ++k) {
    if (zeros == 1 && weights[k + 1] == 0) {
      const int t = mesh_->across[static_cast<std::size_t>(slot.triangle)][k];
      if (t != SurfaceMesh::none && !has(t, slot.point)) visit(t);
    } else if (zeros == 2 && weights[k + 1] != 0) {
      const int corner = corners(slot.triangle)[k];
      for (const int t : mesh_->around_point[static_cast<std::size_t>(corner)]) {
        if (t != slot.triangle && !has(t, slot.point)) visit(t);
      }
    }
  }
}

void SurfaceSlots::go_to(int triangle, Slot& slot, const Points& positions) const {
  slot.triangle = triangle;
  slot.nearest = nearest_of(slot);
  slot.last = separation(pair(slot), positions);
}

/// From triangle to triangle beside it, as long as these are nearer.
void SurfaceSlots::go_to_nearest(Slot& slot, const Points& positions) const {
  for (bool goes = true; goes;) {
    goes = false;
    const Slot here = slot;
    for_each_beside(here, [&](int t) {
      Slot there = here;
      go_to(t, there, positions);
      if (there.gap() >= slot.gap()) return;
      slot = there;
      goes = true;
    });
  }
  slot.owner = slot.triangle;
  for_each_beside(slot, [&](int t) { slot.owner = std::min(slot.owner, t); });
}

/// Is it not far, and none of these, of the same point, at the same place and as far off?
bool SurfaceSlots::is_kept(const Slot& slot, const Slot* begin, const Slot* end) const {
  return slot.last.distance <= reach * slot.nearest &&
         std::none_of(begin, end, [&](const Slot& other) {
           return other.owner == slot.owner && other.nearest >= slot.nearest;
         });
}

std::int64_t SurfaceSlots::walk(const Points& positions, const Workers& workers) {
  workers.each(static_cast<int>(slots_.size()), [&](int point) {
    std::vector<Slot>& slots = slots_[static_cast<std::size_t>(point)];
    std::size_t kept = 0;
    for (Slot& slot : slots) {
      slot.last = separation(pair(slot), positions);
      go_to_nearest(slot, positions);
      if (is_kept(slot, slots.data(), slots.data() + kept)) slots[kept++] = slot;
    }
    slots.resize(kept);
  });
  std::int64_t left = 0;
  for (const std::vector<Slot>& slots : slots_) left += static_cast<std::int64_t>(slots.size());
  return left;
}

bool SurfaceSlots::covers(const Proposal& proposal, float distance, float nearest) const {
  const std::vector<Slot>& slots = of(proposal.point);
  return std::any_of(slots.begin(), slots.end(), [&](const Slot& slot) {
    if (slot.triangle == proposal.triangle) return true;
    // A neighbour on the cloth that may come nearer does not keep off what may not.
    const auto of_slot = static_cast<float>(slot.nearest);
    if (of_slot < nearest || slot.gap() > distance - nearest) return false;
    const auto& of = corners(slot.triangle);
    return std::any_of(of.begin(), of.end(),
                       [&](int point) { return has(proposal.triangle, point); });
  });
}

void SurfaceSlots::add(std::vector<Proposal> proposals, const Points& positions) {
  std::sort(proposals.begin(), proposals.end());
  for (const Proposal& proposal : proposals) {
    Slot slot{proposal.point, 0, proposal.triangle, proposal.triangle};
    go_to(proposal.triangle, slot, positions);
    go_to_nearest(slot, positions);
    std::vector<Slot>& others = slots_[static_cast<std::size_t>(slot.point)];
    if (!is_kept(slot, others.data(), others.data() + others.size())) continue;
    // The first number that is free.
    auto place = others.begin();
    for (; place != others.end() && place->number == slot.number; ++place) ++slot.number;
    others.insert(place, slot);
  }
}

void SurfaceSlots::clear() {
  for (std::vector<Slot>& slots : slots_) slots.clear();
}

void SurfaceSlots::write(MemoryWriter& memory) const {
  for (const std::vector<Slot>& slots : slots_) {
    memory.add(static_cast<double>(slots.size()));
    for (const Slot& slot : slots) {
      memory.add(slot.number);
      memory.add(slot.triangle);
    }
  }
}

void SurfaceSlots::read(MemoryReader& memory) {
  for (int point = 0; point < static_cast<int>(slots_.size()); ++point) {
    std::vector<Slot>& slots = slots_[static_cast<std::size_t>(point)];
    slots.clear();
    for (std::size_t left = memory.count(); left > 0; --left) {
      Slot slot{point, memory.index(mesh_->triangles.size()), memory.index(mesh_->triangles.size()),
                0};
      slot.nearest = nearest_of(slot);
      slots.push_back(slot);
    }
  }
}

}  // namespace clothsim
