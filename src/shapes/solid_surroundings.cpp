// The ridges and faces of a solid near a triangle, kept for the next query.

#include <algorithm>
#include <cmath>

#include "clothsim/shapes/solid.h"

namespace clothsim {

bool Solid::Surroundings::cover(const Corners& t, double reach) const {
  const double room = std::min(faces_within, ridges_within - reach);
  if (room < 0) return false;
  double moved2 = 0;
  for (std::size_t k = 0; k < 3; ++k) moved2 = std::max(moved2, (t[k] - place[k]).squaredNorm());
  return moved2 <= room * room;
}

void Solid::look_around(const Corners& t, double reach, Surroundings& around) const {
  if (around.cover(t, reach)) return;
  around.place = t;
  around.faces_within = reach / 2;
  around.ridges_within = reach + around.faces_within;
  const TriangleBound bound(t);
  std::vector<std::pair<double, int>> near;
  double most2 = std::pow(around.ridges_within, 2);
  ridge_tree_.search(bound, most2, [&](int i) {
    const double least2 = bound.of(ridges_[static_cast<std::size_t>(i)].ends);
    if (least2 <= most2) near.push_back({least2, i});
  });
  std::sort(near.begin(), near.end());
  around.ridges.clear();
  for (const auto& ridge : near) around.ridges.push_back(ridge.second);

  around.faces.clear();
  most2 = std::pow(around.faces_within, 2);
  face_tree_.search(bound, most2, [&](int i) {
    if (bound.of(corners_[static_cast<std::size_t>(i)]) <= most2) around.faces.push_back(i);
  });
  std::sort(around.faces.begin(), around.faces.end());
}

}  // namespace clothsim
