#include "clothsim/geometry/surface_pair.h"

#include <algorithm>

#include "clothsim/geometry/closest_points.h"

namespace clothsim {
namespace {

double along(const Vector3& direction, const Points& positions, int i) {
  return direction[0] * positions(i, 0) + direction[1] * positions(i, 1) +
         direction[2] * positions(i, 2);
}

/// How far the points of a lie beyond those of b, by their coordinates on an axis.
template <typename Place>
double gap_of(const SurfacePair& pair, const Place& place_of) {
  std::array<double, 4> place;
  for (std::size_t k = 0; k < 4; ++k) place[k] = place_of(pair.points[k]);
  const double farther = std::max(place[2], place[3]);
  return pair.edges() ? std::min(place[0], place[1]) - farther
                      : place[0] - std::max(place[1], farther);
}

}  // namespace

Separation separation(const SurfacePair& pair, const Points& positions) {
  const auto at = [&](std::size_t k) {
    const int i = pair.points[k];
    return Vector3(positions(i, 0), positions(i, 1), positions(i, 2));
  };
  const Vector3 p0 = at(0), p1 = at(1), p2 = at(2), p3 = at(3);
  Separation result;
  Vector3 d;
  if (pair.edges()) {
    const auto [s, t] = closest_on_segments(p0, p1, p2, p3);
    result.weights = {1 - s, s, t - 1, -t};
    d = (1 - s) * p0 + s * p1 - (1 - t) * p2 - t * p3;
  } else {
    const auto [u, v, w] = closest_on_triangle(p0, p1, p2, p3);
    result.weights = {1, -u, -v, -w};
    d = p0 - u * p1 - v * p2 - w * p3;
  }
  result.distance = d.norm();
  result.normal = result.distance > 0 ? Vector3(d / result.distance) : Vector3::Zero();
  return result;
}

double gap_along(const Vector3& direction, const SurfacePair& pair, const Points& positions) {
  return gap_of(pair, [&](int i) { return along(direction, positions, i); });
}

double min_gap_turning(const SurfacePair& pair, const Points& start, const Points& end) {
  const SurfacePair four{pair.triangle, {0, 1, 2, 3}, pair.nearest};
  Points from(4, 3), to(4, 3);
  for (int k = 0; k < 4; ++k) {
    from.row(k) = start.row(pair.points[static_cast<std::size_t>(k)]);
    to.row(k) = end.row(pair.points[static_cast<std::size_t>(k)]);
  }
  const Vector3 first = separation(four, from).normal, last = separation(four, to).normal;
  // Middle control point of the parabola that passes through the normal half way.
  const Vector3 half_way = separation(four, (from + to) / 2).normal;
  const Vector3 middle = 2 * half_way - (first + last) / 2;
  const auto coefficient = [&](const auto& place) { return gap_of(four, place); };
  return std::min(
      {coefficient([&](int i) { return along(first, from, i); }),
       coefficient([&](int i) { return (2 * along(middle, from, i) + along(first, to, i)) / 3; }),
       coefficient([&](int i) { return (along(last, from, i) + 2 * along(middle, to, i)) / 3; }),
       coefficient([&](int i) { return along(last, to, i); })});
}

}  // namespace clothsim
