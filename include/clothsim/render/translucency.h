#pragma once

#include <array>
#include <vector>

#include "clothsim/render/draw_item.h"

namespace clothsim {

/// Triangles of several objects, farthest first, in runs of one object each.
struct BackToFront {
  struct Stretch {
    const DrawItem* item;
    int first;  // triangle
    int count;
  };
  std::vector<std::array<int, 3>> triangles;
  std::vector<Stretch> stretches;
};

/// Sorts the triangles of all items by the depth of their centroid along `forward`.
BackToFront sort_back_to_front(const std::vector<const DrawItem*>& items, const Vector3& forward);

}  // namespace clothsim
