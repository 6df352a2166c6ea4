#pragma once

#include "clothsim/model/checks.h"

namespace clothsim {

// Values that an image shows; the bounds keep the sums in the shaders finite.
constexpr Range coordinate_range{-1e6, 1e6, "m"};
constexpr Range channel_range{0, 1, ""};

}  // namespace clothsim
