#pragma once

#include "clothsim/constraints/contact_step.h"
#include "clothsim/model/cloth.h"
#include "clothsim/model/state.h"
#include "clothsim/search/near_pairs.h"

namespace clothsim {

/// Lets the points of a cloth move from the start of a step to `state` as far as its surface cannot
/// cross itself, whatever moves them, and returns how many it holds back. These have the velocity
/// of the way they made, and no more than they had.
///
/// Between two measurements of distances, points move on straight ways. Two features between which
/// there are planes of one direction at both ends have one all the way. Where none of the direction
/// in which they are closest now will be between them, no point of them goes farther than a share,
/// below a half, of their distance (Chen et al. 2025, "Offset Geometric Contact"; Lan et al. 2024,
/// Gaia).
///
/// `by_impulses`: where the points would be before repairs of springs and push-outs of colliders
/// [m]. These know nothing of the cloth's contact with itself, so what touches, and is held
/// together by them alone, goes without.
int keep_from_crossing(const Cloth&, const ContactStep&, const Points& by_impulses, NearPairs&,
                       State&);

}  // namespace clothsim
