#include "clothsim/search/surface_slots.h"

#include <algorithm>
#include <tuple>
#include <utility>

namespace clothsim {

SurfaceSlots::SurfaceSlots(std::shared_ptr<const SurfaceMesh> mesh,
                           std::shared_ptr<const NearestDistances> nearest)
    : mesh_(std::move(mesh)), nearest_(std::move(nearest)), slots_(mesh_->around_point.size()) {}

bool SurfaceSlots::has(int triangle, int point) const {
  const auto& [a, b, c] = corners(triangle);
  return a == point || b == point || c == point;
}

SurfacePair SurfaceSlots::pair(int point, int triangle) const {
  const auto& [a, b, c] = corners(triangle);
  return {
      triangle, {point, a, b, c}, nearest_->of(point, a, static_cast<std::size_t>(triangle % 2))};
}

/// Triangles beside a slot's that hold its closest place, too: beyond an edge, around a corner.
template <typename Visit>
void SurfaceSlots::for_each_beside(const Slot& slot, const Visit& visit) const {
  std::array<int, 3> holding;  // corners, those of the edge or the one
  std::size_t count = 0;
  for (std::size_t k = 1; k <= 3; ++k) {
    if (slot.last.weights[k] != 0) holding[count++] = slot.pair.points[k];
  }
  if (count == 3) return;
  for (const int t : mesh_->around_point[static_cast<std::size_t>(holding[0])]) {
    if (t != slot.pair.triangle && has(t, holding[count - 1]) && !has(t, slot.pair.points[0])) {
      visit(t);
    }
  }
}

/// From triangle to triangle beside it, as long as these are nearer.
void SurfaceSlots::go_to_nearest(Slot& slot, const Points& positions) const {
  for (bool goes = true; goes;) {
    goes = false;
    const Slot here = slot;
    for_each_beside(here, [&](int t) {
      Slot there = here;
      there.pair = pair(there.pair.points[0], t);
      there.last = separation(there.pair, positions);
      if (there.gap() >= slot.gap()) return;
      slot = there;
      goes = true;
    });
  }
  slot.owner = slot.pair.triangle;
  for_each_beside(slot, [&](int t) { slot.owner = std::min(slot.owner, t); });
}

/// Is it not far, and none of these, of the same point, at the same place and as far off?
bool SurfaceSlots::is_kept(const Slot& slot, const Slot* begin, const Slot* end) const {
  return slot.last.distance <= reach * slot.pair.nearest &&
         std::none_of(begin, end, [&](const Slot& other) {
           return other.owner == slot.owner && other.pair.nearest >= slot.pair.nearest;
         });
}

std::int64_t SurfaceSlots::walk(const Points& positions, const Workers& workers) {
  workers.each(static_cast<int>(slots_.size()), [&](int point) {
    std::vector<Slot>& slots = slots_[static_cast<std::size_t>(point)];
    std::size_t kept = 0;
    for (Slot& slot : slots) {
      slot.last = separation(slot.pair, positions);
      go_to_nearest(slot, positions);
      if (is_kept(slot, slots.data(), slots.data() + kept)) slots[kept++] = slot;
    }
    slots.resize(kept);
  });
  std::int64_t left = 0;
  for (const std::vector<Slot>& slots : slots_) left += static_cast<std::int64_t>(slots.size());
  return left;
}

bool SurfaceSlots::covers(const SurfacePair& pair, float distance) const {
  const std::vector<Slot>& slots = of(pair.points[0]);
  const auto nearest = static_cast<float>(pair.nearest);
  return std::any_of(slots.begin(), slots.end(), [&](const Slot& slot) {
    if (slot.pair.triangle == pair.triangle) return true;
    // A neighbour on the cloth that may come nearer does not keep off what may not.
    const auto of_slot = static_cast<float>(slot.pair.nearest);
    if (of_slot < nearest || slot.gap() > distance - nearest) return false;
    const auto& of = corners(slot.pair.triangle);
    return std::any_of(of.begin(), of.end(), [&](int point) { return has(pair.triangle, point); });
  });
}

void SurfaceSlots::add(std::vector<SurfacePair> pairs, const Points& positions) {
  std::sort(pairs.begin(), pairs.end(), [](const SurfacePair& a, const SurfacePair& b) {
    return std::tie(a.points[0], a.triangle) < std::tie(b.points[0], b.triangle);
  });
  for (const auto& [triangle, points, nearest] : pairs) {
    // Its nearest to the last bit, from whichever side its tiles were looked at.
    Slot slot{pair(points[0], triangle), 0, triangle};
    slot.last = separation(slot.pair, positions);
    go_to_nearest(slot, positions);
    std::vector<Slot>& others = slots_[static_cast<std::size_t>(points[0])];
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
      memory.add(slot.pair.triangle);
    }
  }
}

void SurfaceSlots::read(MemoryReader& memory) {
  for (int point = 0; point < static_cast<int>(slots_.size()); ++point) {
    std::vector<Slot>& slots = slots_[static_cast<std::size_t>(point)];
    slots.clear();
    for (std::size_t left = memory.count(); left > 0; --left) {
      const int number = memory.index(mesh_->triangles.size());
      slots.push_back({pair(point, memory.index(mesh_->triangles.size())), number, 0});
    }
  }
}

}  // namespace clothsim
