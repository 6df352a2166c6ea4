// The ridges and faces of a solid near a triangle, kept for the next query.

#include <algorithm>
#include <cmath>

#include "clothsim/shapes/solid.h"
#include "shape_parts.h"

namespace clothsim {
namespace {

/// Distance between a triangle and a segment; 0 where the segment passes through [m].
double distance_to_segment(const Triangle& t, const Vector3& a, const Vector3& b) {
  if (passes_through(a, b, t)) return 0;
  Closest closest;
  closest.add_line(a, b, t);
  for (const Vector3& p : {a, b}) closest.add(p, t, closest_on_triangle(p, t[0], t[1], t[2]));
  return closest.least();
}

}  // namespace

bool Solid::Surroundings::cover(const Corners& t, double reach) const {
  return longest_displacement(place, t) <= std::min(faces_within, ridges_within - reach);
}

void Solid::look_around(const Corners& t, double reach, Surroundings& around) const {
  if (around.cover(t, reach)) return;
  around.place = t;
  around.faces_within = reach / 2;
  around.ridges_within = reach + around.faces_within;
  const TriangleBound bound(t);
  double most2 = std::pow(around.ridges_within, 2);
  std::vector<std::pair<double, int>> ridges;
  ridge_tree_.search(bound, most2, [&](int i) {
    const double least2 = bound.of(ridges_[static_cast<std::size_t>(i)].ends);
    if (least2 <= most2) ridges.push_back({std::sqrt(least2), i});
  });
  std::sort(ridges.begin(), ridges.end());
  around.ridges = {ridges.begin(), ridges.end()};  // no larger than needed

  most2 = std::pow(around.faces_within, 2);
  std::vector<int> faces;
  face_tree_.search(bound, most2, [&](int i) {
    if (bound.of(corners_[static_cast<std::size_t>(i)]) <= most2) faces.push_back(i);
  });
  std::sort(faces.begin(), faces.end());
  around.faces = {faces.begin(), faces.end()};
}

bool Solid::is_ridge_within(const Corners& t, double reach, Surroundings* around) const {
  const TriangleBound bound(t);
  const double reach2 = beyond_rounding * reach * reach;
  const auto is_within = [&](int i) {
    const auto& [a, b] = ridges_[static_cast<std::size_t>(i)].ends;
    return bound.of(ridges_[static_cast<std::size_t>(i)].ends) <= reach2 &&
           distance_to_segment(t, a, b) <= reach;
  };
  if (around && around->cover(t, reach)) {
    return std::any_of(around->ridges.begin(), around->ridges.end(),
                       [&](const auto& ridge) { return is_within(ridge.second); });
  }
  bool found = false;
  double most2 = reach2;
  ridge_tree_.search(bound, most2, [&](int i) {
    found = found || is_within(i);
    if (found) most2 = -1;
  });
  if (!found && around) look_around(t, reach, *around);  // few ridges, for the next time
  return found;
}

}  // namespace clothsim
