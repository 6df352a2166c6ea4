// The ridges and faces of a solid near a triangle, kept for the next query.

#include <algorithm>
#include <cmath>

#include "clothsim/shapes/solid.h"

namespace clothsim {

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
  around.ridges.clear();
  ridge_tree_.search(bound, most2, [&](int i) {
    const double least2 = bound.of(ridges_[static_cast<std::size_t>(i)].ends);
    if (least2 <= most2) around.ridges.push_back({std::sqrt(least2), i});
  });
  std::sort(around.ridges.begin(), around.ridges.end());

  around.faces.clear();
  most2 = std::pow(around.faces_within, 2);
  face_tree_.search(bound, most2, [&](int i) {
    if (bound.of(corners_[static_cast<std::size_t>(i)]) <= most2) around.faces.push_back(i);
  });
  std::sort(around.faces.begin(), around.faces.end());
}

bool Solid::may_touch_ridge(const Corners& t, double reach, const Surroundings* around) const {
  if (around && around->ridges.empty()) return false;
  const TriangleBound bound(t);
  const auto is_near = [&](int i) {
    return bound.of(ridges_[static_cast<std::size_t>(i)].ends) <= reach * reach;
  };
  if (around) {
    return std::any_of(around->ridges.begin(), around->ridges.end(),
                       [&](const auto& ridge) { return is_near(ridge.second); });
  }
  bool found = false;
  double most2 = reach * reach;
  ridge_tree_.search(bound, most2, [&](int i) {
    found = found || is_near(i);
    if (found) most2 = -1;
  });
  return found;
}

}  // namespace clothsim
