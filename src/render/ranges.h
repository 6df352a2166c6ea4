#pragma once

#include "clothsim/model/checks.h"

namespace clothsim {

constexpr Range coordinate_range{-1e6, 1e6, "m"};  // single precision resolves 6 cm there
constexpr Range channel_range{0, 1, ""};           // of a colour

}  // namespace clothsim
