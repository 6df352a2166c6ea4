#pragma once

#include <cstdint>

#include "clothsim/model/cloth.h"
#include "clothsim/model/cloth_spec.h"
#include "clothsim/model/state.h"

namespace clothsim {

/// The grid cloth of `spec`: point (column, row) has index row * columns + column. Each point has
/// the mass width * height * density / (columns * rows), or with a fabric that of the area it owns,
/// see add_fabric(). `gravity` [m/s^2], the magnitude, decides whether points are enough for
/// automatic self collision. Throws InvalidValue.
Cloth make_grid(const ClothSpec& spec, double gravity = 9.8);

/// Sets damping, drag, strain limit, contact and pins of `spec`, for a cloth of any shape.
void set_common(const ClothSpec& spec, Cloth& cloth);

/// Largest initial offset of a vertical cloth's points from its plane [m]: 1 mm, or a twentieth of
/// a cell's shorter side or of a mesh's shortest edge if that is less, which stretches no spring by
/// more than 0.5 %.
double unevenness(const Cloth&);

/// The cloth at rest in its initial position. Points of a vertical cloth are off its plane by up to
/// unevenness(), at random from `seed`, so that it folds; its rest lengths are those of the flat
/// grid.
State start_state(const ClothSpec& spec, const Cloth& cloth, std::uint64_t seed);

}  // namespace clothsim
