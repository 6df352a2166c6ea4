#include "clothsim/search/surface_slots.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "clothsim/model/errors.h"

namespace clothsim {

SurfaceSlots::SurfaceSlots(std::shared_ptr<const SurfaceMesh> mesh,
                           std::shared_ptr<const NearestDistances> nearest)
    : mesh_(std::move(mesh)), nearest_(std::move(nearest)), slots_(mesh_->around_point.size()) {}

SurfacePair SurfaceSlots::pair(int point, int triangle) const {
  const auto& [a, b, c] = corners(triangle);
  return {triangle, {point, a, b, c}, nearest_->of_slot(point, triangle)};
}

/// Triangles beside a slot's that hold its closest place, too: beyond an edge, around a corner.
template <typename Visit>
void SurfaceSlots::for_each_beside(const Slot& slot, const Visit& visit) const {
  const auto& points = slot.pair.points;
  const auto& weights = slot.last.weights;
  if (std::count(weights.begin(), weights.end(), 0.0) == 0) return;
  const std::size_t k = weights[1] != 0 ? 1 : weights[2] != 0 ? 2 : 3;
  for (const int t : mesh_->around_point[static_cast<std::size_t>(points[k])]) {
    bool holds = t != slot.pair.triangle && !has(t, points[0]);
    for (std::size_t l = k + 1; l <= 3; ++l) {
      holds = holds && (weights[l] == 0 || has(t, points[l]));
    }
    if (holds) visit(t);
  }
}

/// From triangle to triangle beside it, as long as these have a smaller gap.
void SurfaceSlots::go_to_nearest(Slot& slot, const Points& positions) const {
  for (bool goes = true; goes;) {
    goes = false;
    const Slot here = slot;
    const auto along = [&](int point) { return here.last.normal.dot(row(positions, point)); };
    const double place = along(here.pair.points[0]) - here.last.distance;
    slot.owner = here.pair.triangle;
    for_each_beside(here, [&](int t) {
      slot.owner = std::min(slot.owner, t);
      // Nearer places lie towards a corner on the point's side of the closest one.
      const bool leads_nearer = std::any_of(corners(t).begin(), corners(t).end(), [&](int corner) {
        return !has(here.pair.triangle, corner) && along(corner) > place;
      });
      const SurfacePair beside = pair(here.pair.points[0], t);
      if (!leads_nearer && beside.nearest <= here.pair.nearest) return;
      // Where it touches it stays: what may come nearer there would let it come nearer here.
      const double nearer = slot.pair.nearest - beside.nearest;
      if (nearer > 0 && slot.gap() <= nearer) return;
      const Separation s = separation(beside, positions);
      if (s.distance - beside.nearest >= slot.gap()) return;
      slot.pair = beside;
      slot.last = s;
      goes = true;
    });
  }
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

void SurfaceSlots::add(std::vector<SurfacePair> pairs, const Points& positions,
                       const Workers& workers) {
  std::sort(pairs.begin(), pairs.end(), [](const SurfacePair& a, const SurfacePair& b) {
    return std::tie(a.points[0], a.triangle) < std::tie(b.points[0], b.triangle);
  });
  std::vector<std::size_t> first;  // of each point
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    if (k == 0 || pairs[k].points[0] != pairs[k - 1].points[0]) first.push_back(k);
  }
  const auto points = static_cast<int>(first.size());
  first.push_back(pairs.size());
  workers.each(points, [&](int number) {
    const auto of = static_cast<std::size_t>(number);
    for (std::size_t k = first[of]; k < first[of + 1]; ++k) {
      add(pairs[k].points[0], pairs[k].triangle, positions);
    }
  });
}

/// Its nearest to the last bit, from whichever side its tiles were looked at.
void SurfaceSlots::add(int point, int triangle, const Points& positions) {
  Slot slot{pair(point, triangle), 0, triangle};
  slot.last = separation(slot.pair, positions);
  go_to_nearest(slot, positions);
  std::vector<Slot>& others = slots_[static_cast<std::size_t>(point)];
  if (!is_kept(slot, others.data(), others.data() + others.size())) return;
  // The first number that is free.
  auto place = others.begin();
  for (; place != others.end() && place->number == slot.number; ++place) ++slot.number;
  others.insert(place, slot);
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
      if (!slots.empty() && slots.back().number >= number) {
        throw InvalidValue({"memory"}, "slots in another order", "what this cloth wrote");
      }
      slots.push_back({pair(point, memory.index(mesh_->triangles.size())), number, 0});
    }
  }
}

}  // namespace clothsim
