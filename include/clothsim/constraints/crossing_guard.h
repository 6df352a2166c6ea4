#pragma once

#include "clothsim/constraints/contact_step.h"
#include "clothsim/model/cloth.h"
#include "clothsim/model/state.h"
#include "clothsim/search/near_pairs.h"

namespace clothsim {

/// Lets the points of a cloth move from the start of a step to `state` as far as its surface cannot
/// cross itself, whatever moves them. Returns the number of truncated points. Their velocity
/// becomes that of the truncated displacement, with at most the speed that they had.
///
/// Between two measurements of distances points move on straight paths. Two features that are
/// separated at both ends by planes of one direction are separated all the way. Where no plane
/// along their present shortest distance separates them afterwards, no point of them moves farther
/// than half of that distance, less a floor (Chen et al. 2025, "Offset Geometric Contact"; Lan et
/// al. 2024, Gaia).
///
/// `by_impulses`: positions [m] before the projections of springs and of colliders. Projections do
/// not account for self contact: features in contact that projections alone hold together go
/// without them.
int keep_from_crossing(const Cloth&, const ContactStep&, const Points& by_impulses, NearPairs&,
                       State&);

}  // namespace clothsim
