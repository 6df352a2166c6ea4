#include "clothsim/search/tracked_pairs.h"

#include <algorithm>
#include <atomic>
#include <tuple>
#include <utility>

#include "clothsim/model/errors.h"

namespace clothsim {

TrackedPairs::TrackedPairs(std::shared_ptr<const SurfaceMesh> mesh,
                           std::shared_ptr<const NearestDistances> nearest)
    : mesh_(std::move(mesh)), nearest_(std::move(nearest)), pairs_(mesh_->around_point.size()) {}

SurfacePair TrackedPairs::pair(int point, int triangle) const {
  const auto& [a, b, c] = corners(triangle);
  return {triangle, {point, a, b, c}, nearest_->of_tracked(point, triangle)};
}

/// Adjacent triangles that contain the pair's closest place, too: beyond an edge, around a corner.
template <typename Visit>
void TrackedPairs::for_each_adjacent(const TrackedPair& tracked_pair, const Visit& visit) const {
  const auto& points = tracked_pair.pair.points;
  const auto& weights = tracked_pair.last.weights;
  if (std::count(weights.begin(), weights.end(), 0.0) == 0) return;
  const std::size_t k = weights[1] != 0 ? 1 : weights[2] != 0 ? 2 : 3;
  for (const int t : mesh_->around_point[static_cast<std::size_t>(points[k])]) {
    bool holds = t != tracked_pair.pair.triangle && !has(t, points[0]);
    for (std::size_t l = k + 1; l <= 3; ++l) {
      holds = holds && (weights[l] == 0 || has(t, points[l]));
    }
    if (holds) visit(t);
  }
}

/// Moves a pair from triangle to adjacent triangle while the gap gets smaller.
void TrackedPairs::go_to_nearest(TrackedPair& tracked_pair, const Points& positions) const {
  for (bool goes = true; goes;) {
    goes = false;
    const TrackedPair here = tracked_pair;
    const auto along = [&](int point) { return here.last.normal.dot(row(positions, point)); };
    const double place = along(here.pair.points[0]) - here.last.distance;
    tracked_pair.owner = here.pair.triangle;
    for_each_adjacent(here, [&](int t) {
      tracked_pair.owner = std::min(tracked_pair.owner, t);
      // Nearer places lie towards a corner on the point's side of the closest one.
      const bool leads_nearer = std::any_of(corners(t).begin(), corners(t).end(), [&](int corner) {
        return !has(here.pair.triangle, corner) && along(corner) > place;
      });
      const SurfacePair adjacent = pair(here.pair.points[0], t);
      if (!leads_nearer && adjacent.nearest <= here.pair.nearest) return;
      // A pair in contact stays: a smaller contact distance there would let it come nearer here.
      const double nearer = tracked_pair.pair.nearest - adjacent.nearest;
      if (nearer > 0 && tracked_pair.gap() <= nearer) return;
      const Separation s = separation(adjacent, positions);
      if (s.distance - adjacent.nearest >= tracked_pair.gap()) return;
      tracked_pair.pair = adjacent;
      tracked_pair.last = s;
      goes = true;
    });
  }
}

/// Is it near, and at another place than these pairs of the same point with at least its contact
/// distance?
bool TrackedPairs::is_kept(const TrackedPair& tracked_pair, const TrackedPair* begin,
                           const TrackedPair* end) const {
  return tracked_pair.last.distance <= range * tracked_pair.pair.nearest &&
         std::none_of(begin, end, [&](const TrackedPair& other) {
           return other.owner == tracked_pair.owner &&
                  other.pair.nearest >= tracked_pair.pair.nearest;
         });
}

std::int64_t TrackedPairs::track(const Points& positions, const Workers& workers) {
  std::atomic<std::int64_t> left{0};
  const auto track_band = [&](int begin, int end) {
    std::int64_t of_band = 0;
    for (int point = begin; point < end; ++point) {
      std::vector<TrackedPair>& tracked = pairs_[static_cast<std::size_t>(point)];
      std::size_t kept = 0;
      for (TrackedPair& tracked_pair : tracked) {
        tracked_pair.last = separation(tracked_pair.pair, positions);
        go_to_nearest(tracked_pair, positions);
        if (is_kept(tracked_pair, tracked.data(), tracked.data() + kept)) {
          tracked[kept++] = tracked_pair;
        }
      }
      tracked.resize(kept);
      of_band += static_cast<std::int64_t>(kept);
    }
    left += of_band;
  };
  workers.parallel_for(static_cast<int>(pairs_.size()), track_band, Workers::dear, Workers::uneven);
  return left;
}

bool TrackedPairs::covers(const SurfacePair& pair, float distance) const {
  const std::vector<TrackedPair>& tracked = of(pair.points[0]);
  const auto nearest = static_cast<float>(pair.nearest);
  return std::any_of(tracked.begin(), tracked.end(), [&](const TrackedPair& tracked_pair) {
    if (tracked_pair.pair.triangle == pair.triangle) return true;
    // A neighbour with a smaller contact distance does not keep off one with a larger one.
    const auto of_tracked = static_cast<float>(tracked_pair.pair.nearest);
    if (of_tracked < nearest || tracked_pair.gap() > distance - nearest) return false;
    const auto& of = corners(tracked_pair.pair.triangle);
    return std::any_of(of.begin(), of.end(), [&](int point) { return has(pair.triangle, point); });
  });
}

void TrackedPairs::add(std::vector<SurfacePair> pairs, const Points& positions,
                       const Workers& workers) {
  std::sort(pairs.begin(), pairs.end(), [](const SurfacePair& a, const SurfacePair& b) {
    return std::tie(a.points[0], a.triangle) < std::tie(b.points[0], b.triangle);
  });
  std::vector<std::size_t> first;  // by point
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

/// Its nearest triangle is the same to the last bit, whichever side its tiles were measured from.
void TrackedPairs::add(int point, int triangle, const Points& positions) {
  TrackedPair tracked_pair{pair(point, triangle), 0, triangle};
  tracked_pair.last = separation(tracked_pair.pair, positions);
  go_to_nearest(tracked_pair, positions);
  std::vector<TrackedPair>& others = pairs_[static_cast<std::size_t>(point)];
  if (!is_kept(tracked_pair, others.data(), others.data() + others.size())) return;
  // The first free number.
  auto place = others.begin();
  for (; place != others.end() && place->number == tracked_pair.number; ++place)
    ++tracked_pair.number;
  others.insert(place, tracked_pair);
}

void TrackedPairs::write(MemoryWriter& memory) const {
  for (const std::vector<TrackedPair>& tracked : pairs_) {
    memory.add(static_cast<double>(tracked.size()));
    for (const TrackedPair& tracked_pair : tracked) {
      memory.add(tracked_pair.number);
      memory.add(tracked_pair.pair.triangle);
    }
  }
}

void TrackedPairs::read(MemoryReader& memory) {
  for (int point = 0; point < static_cast<int>(pairs_.size()); ++point) {
    std::vector<TrackedPair>& tracked = pairs_[static_cast<std::size_t>(point)];
    tracked.clear();
    for (std::size_t left = memory.count(); left > 0; --left) {
      const int number = memory.index(mesh_->triangles.size());
      if (!tracked.empty() && tracked.back().number >= number) {
        throw InvalidValue({"memory"}, "pairs in another order", "the memory of this cloth");
      }
      tracked.push_back({pair(point, memory.index(mesh_->triangles.size())), number, 0});
    }
  }
}

}  // namespace clothsim
