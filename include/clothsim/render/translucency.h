#pragma once

#include <array>
#include <vector>

#include "clothsim/render/camera.h"
#include "clothsim/render/draw_item.h"

namespace clothsim {

/// Triangles of several objects in runs of one object each. Where triangles cover the same pixel,
/// the farther one comes first.
struct BackToFront {
  struct Run {
    const DrawItem* item;
    int first;  // triangle
    int count;
  };
  std::vector<std::array<int, 3>> triangles;
  std::vector<Run> runs;
};

/// Sorts the triangles of all items by the depth of their centroid, and collects those of an object
/// that have no common pixel with the triangles of other objects in between.
BackToFront sort_back_to_front(const std::vector<const DrawItem*>& items, const Camera&);

}  // namespace clothsim
