#include "clothsim/constraints/untangle.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "clothsim/geometry/crossing_contours.h"
#include "clothsim/shapes/shape.h"

namespace clothsim {
namespace {

/// Largest number of passes: crossings of small depth take up to 50.
constexpr int max_passes = 200;

/// Displacement of a point in a pass towards the surface that it crosses, at most, of the shortest
/// edge: small relative to the distance between one layer and the next but one.
constexpr double max_move_share = 0.2;

/// Displacement of such a point beyond that surface, of the shortest edge: it ends clearly on its
/// own side.
constexpr double overshoot = 0.02;

/// Share of the mean displacement of its neighbours that a point takes, and cells over which they
/// take it along: so the cloth bends where it moves, and does not crease.
constexpr double passed_on = 0.9;
constexpr int max_rounds = 8;

/// Sine of an edge's angle with a triangle, at least, where a contour is made shorter.
constexpr double min_sine = 0.1;

/// A contour that divides no surface must become shorter by this share of the displacement at each
/// crossing: less occurs for a straight one, and is no indication.
constexpr double min_shortening = 0.2;

/// Points of a surface on either side of a contour.
struct PartSizes {
  std::array<int, 2> below_and_above;  // of the surface that it crosses, by the normal there
  bool are_divided;                    // else the sides join beside an end of the contour
};

/// Counts the points of a surface beside a contour, each on the side to which it is nearer along
/// the surface: where the contour divides the surface, those of the parts.
class PartCounter {
 public:
  explicit PartCounter(const SurfaceEdges& surface)
      : surface_(surface), sides_(surface.of_point.size()), is_cut_(surface.edges.size()) {}

  /// `cuts`: edges that the contour crosses, and whether their first ends are above.
  PartSizes count(const std::vector<std::pair<int, bool>>& cuts) {
    std::fill(sides_.begin(), sides_.end(), none);
    sizes_ = {{0, 0}, true};
    visited_.clear();
    for (const auto& [edge, is_above] : cuts) {
      is_cut_[static_cast<std::size_t>(edge)] = true;
      visit(surface_[edge].points[0], is_above);
      visit(surface_[edge].points[1], !is_above);
    }
    for (std::size_t next = 0; next < visited_.size(); ++next) {
      const int from = visited_[next];
      for (const int edge : surface_.of_point[static_cast<std::size_t>(from)]) {
        if (is_cut_[static_cast<std::size_t>(edge)]) continue;
        for (const int point : surface_[edge].points) visit(point, side(from));
      }
    }
    for (const auto& cut : cuts) is_cut_[static_cast<std::size_t>(cut.first)] = false;
    return sizes_;
  }

 private:
  static constexpr int none = -1;

  int& side(int point) { return sides_[static_cast<std::size_t>(point)]; }

  void visit(int point, int from) {
    if (side(point) != none) {
      sizes_.are_divided = sizes_.are_divided && side(point) == from;
      return;
    }
    side(point) = from;
    ++sizes_.below_and_above[static_cast<std::size_t>(from)];
    visited_.push_back(point);
  }

  const SurfaceEdges& surface_;
  std::vector<int> sides_;  // side by point
  std::vector<bool> is_cut_;
  PartSizes sizes_{};
  std::vector<int> visited_;
};

/// Displacements of points, each the mean of the requested ones.
class Displacements {
 public:
  explicit Displacements(const Cloth& cloth)
      : cloth_(cloth),
        sums_(Points::Zero(cloth.num_points(), 3)),
        weights_(Scalars::Zero(cloth.num_points())) {}

  /// Requests `displacement` [m] of a point relative to a place on a triangle, divided by inverse
  /// mass.
  void ask(int point, const std::array<int, 3>& triangle, const std::array<double, 3>& weights,
           const Vector3& displacement) {
    double mobility = cloth_.inv_mass[point];
    for (std::size_t k = 0; k < 3; ++k) {
      mobility += weights[k] * weights[k] * cloth_.inv_mass[triangle[k]];
    }
    if (mobility == 0) return;
    add(point, 1, displacement / mobility);
    for (std::size_t k = 0; k < 3; ++k) add(triangle[k], weights[k], -displacement / mobility);
  }

  /// The displacements of all points, with those beside the requested ones.
  Points spread(const SurfaceEdges& surface) const {
    Points displacements = sums_;
    for (int i = 0; i < displacements.rows(); ++i)
      displacements.row(i) /= std::max(1.0, weights_[i]);
    for (int round = 0; round < max_rounds; ++round) {
      const Points last = displacements;
      for (int i = 0; i < displacements.rows(); ++i) {
        if (weights_[i] > 0 || cloth_.inv_mass[i] == 0) continue;
        const std::vector<int>& edges = surface.of_point[static_cast<std::size_t>(i)];
        Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
        for (const int edge : edges) {
          const auto& [a, b] = surface[edge].points;
          sum += last.row(a == i ? b : a);
        }
        displacements.row(i) = passed_on / static_cast<double>(edges.size()) * sum;
      }
    }
    return displacements;
  }

 private:
  void add(int point, double weight, const Vector3& impulse) {
    if (weight == 0 || cloth_.inv_mass[point] == 0) return;
    sums_.row(point) += weight * cloth_.inv_mass[point] * impulse.transpose();
    weights_[point] += weight;
  }

  const Cloth& cloth_;
  Points sums_;
  Scalars weights_;
};

/// The surface of a cloth at given positions.
class Surface {
 public:
  Surface(const Cloth& cloth, const SurfaceEdges& edges, const Points& positions)
      : cloth_(cloth), edges_(edges), positions_(positions) {}

  const SurfaceEdges& edges() const { return edges_; }
  const Cloth& cloth() const { return cloth_; }

  /// From the first to the second end of the edge.
  Vector3 along(const EdgeCrossing& c) const {
    return row(positions_, edges_[c.edge].points[1]) - row(positions_, edges_[c.edge].points[0]);
  }

  /// Is the edge's first end above the triangle?
  bool is_above(const EdgeCrossing& c) const { return c.normal.dot(along(c)) < 0; }

  /// Mean normal of the edge's triangles, unit.
  Vector3 normal_at(const EdgeCrossing& c) const {
    Vector3 sum = Vector3::Zero();
    for (const int triangle : edges_[c.edge].triangles) {
      if (triangle >= 0) sum += normal_of(triangle);
    }
    return sum.stableNormalized();
  }

  /// Rate at which the contour becomes shorter there as the edge moves, as a gradient: in both
  /// triangles of the edge a part of the contour ends there.
  Vector3 shortening(const EdgeCrossing& c) const {
    const Vector3 direction = along(c).stableNormalized();
    const Vector3 place = row(positions_, edges_[c.edge].points[0]) + c.share * along(c);
    Vector3 into = Vector3::Zero();  // sum of the directions of these parts
    for (const int triangle : edges_[c.edge].triangles) {
      if (triangle < 0) continue;
      Vector3 middle = Vector3::Zero();
      for (const int i : cloth_.triangles[static_cast<std::size_t>(triangle)]) {
        middle += row(positions_, i) / 3;
      }
      const Vector3 stretch = normal_of(triangle).cross(c.normal).stableNormalized();
      const Vector3 inwards = middle - place - direction.dot(middle - place) * direction;
      into += stretch.dot(inwards) < 0 ? Vector3(-stretch) : stretch;
    }
    const double sine = direction.dot(c.normal);
    const double kept = std::copysign(std::max(std::abs(sine), min_sine), sine);
    return into - into.dot(direction) / kept * c.normal;
  }

 private:
  Vector3 normal_of(int triangle) const {
    const auto& [i, j, k] = cloth_.triangles[static_cast<std::size_t>(triangle)];
    const Vector3 corner = row(positions_, i);
    return (row(positions_, j) - corner).cross(row(positions_, k) - corner).stableNormalized();
  }

  const Cloth& cloth_;
  const SurfaceEdges& edges_;
  const Points& positions_;
};

/// By surface: true where its part above the other one goes back, false where the part below does.
std::array<bool, 2> parts_to_go_back(const Surface& surface, const CrossingContour& contour,
                                     PartCounter& counter) {
  double facing = 0;  // > 0: both surfaces face the same way
  double rise = 0;    // > 0: the contour shortens as the first surface rises over the second
  std::array<PartSizes, 2> sizes{};
  std::size_t count = 0;
  for (std::size_t s = 0; s < 2; ++s) {
    std::vector<std::pair<int, bool>> cuts;
    for (const EdgeCrossing& c : contour[s]) {
      cuts.push_back({c.edge, surface.is_above(c)});
      const Vector3 normal = surface.normal_at(c), shortening = surface.shortening(c);
      facing += normal.dot(c.normal);
      rise += s == 0 ? shortening.dot(c.normal) : -shortening.dot(normal);
    }
    count += cuts.size();
    constexpr int endless = std::numeric_limits<int>::max();
    sizes[s] = cuts.empty() ? PartSizes{{endless, endless}, false} : counter.count(cuts);
  }

  // The parts on one flank of the contour belong together: for surfaces that face the same way, the
  // part above the second and the part below the first.
  const bool is_turned = facing > 0;
  const auto parts_on = [&](bool flank) { return std::array<bool, 2>{flank, flank != is_turned}; };
  if (!sizes[0].are_divided && !sizes[1].are_divided &&
      std::abs(rise) > min_shortening * static_cast<double>(count)) {
    return parts_on(rise < 0);
  }
  const auto size_on = [&](bool flank) {
    const auto [first, second] = parts_on(flank);
    return std::minmax({sizes[0].below_and_above[first], sizes[1].below_and_above[second]});
  };
  return parts_on(size_on(true) < size_on(false));
}

/// Displacements of a pass that take crossing parts apart. `edge_length`: the shortest edge [m].
Points displacements_apart(const Surface& surface, const std::vector<CrossingContour>& contours,
                           double edge_length) {
  Displacements displacements(surface.cloth());
  PartCounter counter(surface.edges());
  for (const CrossingContour& contour : contours) {
    const std::array<bool, 2> is_part_above = parts_to_go_back(surface, contour, counter);
    for (std::size_t s = 0; s < 2; ++s) {
      for (const EdgeCrossing& c : contour[s]) {
        const bool is_first = surface.is_above(c) == is_part_above[s];
        const double depth =
            std::abs(c.normal.dot(surface.along(c))) * (is_first ? c.share : 1 - c.share);
        const double distance =
            (std::min(depth / edge_length, max_move_share) + overshoot) * edge_length;
        displacements.ask(surface.edges()[c.edge].points[is_first ? 0 : 1],
                          surface.cloth().triangles[static_cast<std::size_t>(c.triangle)],
                          c.weights, (is_part_above[s] ? -distance : distance) * c.normal);
      }
    }
  }
  return displacements.spread(surface.edges());
}

/// Puts points that are in a collider on its surface.
void keep_out(const Cloth& cloth, const std::vector<MovingCollider>& colliders, Points& positions) {
  for (const MovingCollider& collider : colliders) {
    if (!collider.enabled()) continue;
    for (int i = 0; i < cloth.num_points(); ++i) {
      const Vector3 local = to_local(collider.pose(), row(positions, i));
      const Distance distance = signed_distance(collider.shape(), local, local);
      if (cloth.inv_mass[i] == 0 || !(distance.value < 0)) continue;
      positions.row(i) -=
          (collider.pose().orientation * (distance.value * distance.normal)).transpose();
    }
  }
}

double shortest_edge(const Cloth& cloth, const SurfaceEdges& surface) {
  double shortest = infinity;
  for (const auto& [points, triangles] : surface.edges) {
    const Vector3 along =
        row(cloth.rest_positions, points[1]) - row(cloth.rest_positions, points[0]);
    shortest = std::min(shortest, along.norm());
  }
  return shortest;
}

}  // namespace

Untangled untangle(const Cloth& cloth, const std::vector<MovingCollider>& colliders,
                   Points& positions, const std::function<bool()>& is_interrupted) {
  std::vector<TrianglePair> pairs = find_intersections(cloth, positions);
  Untangled result{static_cast<int>(pairs.size()), static_cast<int>(pairs.size())};
  if (pairs.empty()) return result;

  const SurfaceEdges edges(cloth);
  const double edge_length = shortest_edge(cloth, edges);
  Points now = positions;
  for (int pass = 0; pass < max_passes && result.left > 0; ++pass) {
    if (is_interrupted && is_interrupted()) break;
    const auto contours = find_contours(cloth, edges, pairs, now);
    now += displacements_apart({cloth, edges, now}, contours, edge_length);
    keep_out(cloth, colliders, now);
    pairs = find_intersections(cloth, now);
    if (static_cast<int>(pairs.size()) >= result.left) continue;
    result.left = static_cast<int>(pairs.size());
    positions = now;
  }
  return result;
}

}  // namespace clothsim
