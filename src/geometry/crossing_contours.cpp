#include "clothsim/geometry/crossing_contours.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <optional>
#include <utility>

#include "clothsim/geometry/closest_points.h"
#include "clothsim/geometry/orientation.h"

namespace clothsim {
namespace {

/// ContourGroups of items, each on one of two sides: a union-find with parities.
class ContourGroups {
 public:
  int add() {
    parents_.push_back(static_cast<int>(parents_.size()));
    differs_.push_back(false);
    return parents_.back();
  }

  /// The first item of the group, and whether `item` is on the other side.
  std::pair<int, bool> of(int item) const {
    bool differs = false;
    while (parent(item) != item) {
      differs = differs != differs_[static_cast<std::size_t>(item)];
      item = parent(item);
    }
    return {item, differs};
  }

  /// Merges the groups of `a` and `b`, which are on the same side or on opposite ones.
  void join(int a, int b, bool are_apart) {
    const auto [first, first_differs] = of(a);
    const auto [second, second_differs] = of(b);
    if (first == second) return;
    parents_[static_cast<std::size_t>(second)] = first;
    differs_[static_cast<std::size_t>(second)] = (first_differs != second_differs) != are_apart;
  }

 private:
  int parent(int item) const { return parents_[static_cast<std::size_t>(item)]; }

  std::vector<int> parents_;
  std::vector<bool> differs_;  // from the parent
};

/// The side of a plane on which a point lies; +1 where it lies on the plane, so that an edge
/// through the border between two triangles passes through one of them.
int side(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& d) {
  return orientation(a, b, c, d) < 0 ? -1 : 1;
}

/// The crossing of an edge and a triangle, if there is one.
std::optional<EdgeCrossing> crossing_of(const Cloth& cloth, const SurfaceEdges& surface, int edge,
                                        int triangle, const Points& positions) {
  const std::array<int, 3>& corners = cloth.triangles[static_cast<std::size_t>(triangle)];
  const Vector3 p = row(positions, surface[edge].points[0]);
  const Vector3 q = row(positions, surface[edge].points[1]);
  Triangle t;
  for (std::size_t k = 0; k < 3; ++k) t[k] = row(positions, corners[k]);
  if (side(t[0], t[1], t[2], p) == side(t[0], t[1], t[2], q)) return {};
  int turns = 0;  // sum of the signs of the triangle's sides as seen along the edge
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t next = (k + 1) % 3;
    const bool ascends = corners[k] < corners[next];  // the same for both triangles at a side
    turns += ascends ? side(p, q, t[k], t[next]) : -side(p, q, t[next], t[k]);
  }
  if (std::abs(turns) < 3) return {};

  const Vector3 normal = (t[1] - t[0]).cross(t[2] - t[0]).stableNormalized();
  const double height = normal.dot(p - t[0]), depth = normal.dot(t[0] - q);
  if (height + depth == 0) return {};  // only by rounding
  EdgeCrossing crossing{
      edge, triangle, std::clamp(height / (height + depth), 0.0, 1.0), {}, normal};
  crossing.weights = closest_on_triangle(p + crossing.share * (q - p), t[0], t[1], t[2]);
  return crossing;
}

/// Crossings found so far, each once.
class Crossings {
 public:
  Crossings(const Cloth& cloth, const SurfaceEdges& surface, const Points& positions)
      : cloth_(cloth), surface_(surface), positions_(positions) {}

  /// The crossings of one triangle's edges with another triangle, by number.
  std::vector<int> find(int triangle, int through) {
    std::vector<int> found;
    for (const int edge : surface_.of_triangle[static_cast<std::size_t>(triangle)]) {
      const auto [known, is_new] = known_.try_emplace({edge, through}, -1);
      if (is_new) {
        const auto crossing = crossing_of(cloth_, surface_, edge, through, positions_);
        if (crossing) {
          known->second = groups_.add();
          all_.push_back(*crossing);
        }
      }
      if (known->second >= 0) found.push_back(known->second);
    }
    return found;
  }

  ContourGroups& groups() { return groups_; }

  std::vector<CrossingContour> contours() const {
    std::vector<CrossingContour> result;
    std::map<int, std::size_t> contour_of;
    for (std::size_t i = 0; i < all_.size(); ++i) {
      const auto [group, is_other] = groups_.of(static_cast<int>(i));
      const auto [contour, is_new] = contour_of.try_emplace(group, result.size());
      if (is_new) result.emplace_back();
      result[contour->second][is_other].push_back(all_[i]);
    }
    return result;
  }

 private:
  const Cloth& cloth_;
  const SurfaceEdges& surface_;
  const Points& positions_;
  std::vector<EdgeCrossing> all_;
  std::map<std::pair<int, int>, int> known_;  // by edge and triangle; -1: they do not cross
  ContourGroups groups_;
};

}  // namespace

SurfaceEdges::SurfaceEdges(const Cloth& cloth)
    : of_triangle(cloth.triangles.size()), of_point(static_cast<std::size_t>(cloth.num_points())) {
  std::map<std::pair<int, int>, int> known;
  for (std::size_t t = 0; t < cloth.triangles.size(); ++t) {
    for (std::size_t c = 0; c < 3; ++c) {
      const auto [a, b] = std::minmax(cloth.triangles[t][c], cloth.triangles[t][(c + 1) % 3]);
      const auto [at, is_new] = known.try_emplace({a, b}, static_cast<int>(edges.size()));
      of_triangle[t][c] = at->second;
      if (is_new) {
        edges.push_back({{a, b}, {static_cast<int>(t), -1}});
        for (const int i : {a, b}) of_point[static_cast<std::size_t>(i)].push_back(at->second);
      } else {
        edges[static_cast<std::size_t>(at->second)].triangles[1] = static_cast<int>(t);
      }
    }
  }
}

std::vector<CrossingContour> find_contours(const Cloth& cloth, const SurfaceEdges& surface,
                                           const std::vector<TrianglePair>& pairs,
                                           const Points& positions) {
  Crossings crossings(cloth, surface, positions);
  for (const auto& [a, b] : pairs) {
    // Both are ends of a stretch of one contour.
    const std::vector<int> of_a = crossings.find(a, b), of_b = crossings.find(b, a);
    const std::vector<int>& first = of_a.empty() ? of_b : of_a;
    for (const int other : of_a) crossings.groups().join(first.front(), other, false);
    for (const int other : of_b) crossings.groups().join(first.front(), other, !of_a.empty());
  }
  return crossings.contours();
}

}  // namespace clothsim
