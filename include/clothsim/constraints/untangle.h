#pragma once

#include <functional>
#include <vector>

#include "clothsim/model/cloth.h"
#include "clothsim/shapes/moving_collider.h"

namespace clothsim {

/// Pairs of triangles that cross, before and after untangle().
struct Untangled {
  int before = 0;
  int left = 0;
};

/// Resolves self crossings of small depth: moves points of `positions` [m], and less those beside
/// them, until no triangles cross. Where passes run out first, the result is the positions with the
/// fewest crossings. Pins stay; points do not go into colliders.
///
/// Where two surfaces cross, a contour divides each, and the smaller part goes back through the
/// other surface: global intersection analysis (Baraff, Witkin & Kass 2003, "Untangling Cloth"). A
/// contour that divides neither, as at a fold, is made shorter (Volino & Magnenat-Thalmann 2006,
/// "Resolving Surface Collisions through Intersection Contour Minimization").
///
/// `is_interrupted`, if given, is called before each pass and ends them.
Untangled untangle(const Cloth&, const std::vector<MovingCollider>&, Points& positions,
                   const std::function<bool()>& is_interrupted = {});

}  // namespace clothsim
