#include "xpbd_stretch.h"

#include <cmath>

#include "clothsim/dynamics/springs.h"
#include "clothsim/simulation/cloth_size.h"

namespace clothsim {
namespace {

/// Stretch from which on it is told.
constexpr double noticed_stretch = 0.03;

/// Largest stretch = factor * (N g h^2 / a)^exponent, with N cells of length a along the cloth.
struct StretchLaw {
  double factor;
  double exponent;
};

/// A mesh that hangs from an edge: passes move a correction by some rows, so that a substep's fall
/// g h^2 adds up over all. Measured on cotton of 25 to 100 rows.
constexpr StretchLaw hanging_mesh{0.7, 1};

/// A grid that hangs over a collider: its lines and cells are solved by turns. Fitted to cotton,
/// felt and silk of 25 to 100 rows on a post, with 5 to 20 substeps a frame.
constexpr StretchLaw draped_grid{0.15, 0.5};

}  // namespace

std::optional<std::string> xpbd_stretch_text(const SimulationSpec& spec, const Cloth& cloth,
                                             bool over_colliders, int substeps) {
  const bool is_free = (cloth.inv_mass.array() > 0).all();
  if (cloth.is_limited() || (!cloth.is_mesh() && (!is_free || !over_colliders))) return {};
  const StretchLaw law = cloth.is_mesh() ? hanging_mesh : draped_grid;
  const double h = 1 / (spec.frames_per_second * substeps);
  const double falls =
      spec.gravity.norm() * h * h * cells_along(cloth) / shortest_rest_length(cloth);
  const double stretch = law.factor * std::pow(falls, law.exponent);
  if (stretch < noticed_stretch) return {};
  const double needed = substeps * std::pow(stretch / noticed_stretch, 0.5 / law.exponent);
  const auto percent = [](double x) { return std::to_string(std::lround(100 * x)) + " %"; };
  return "by some " + percent(stretch) +
         ", with substeps: " + std::to_string(std::lround(std::ceil(needed))) + " by " +
         percent(noticed_stretch);
}

}  // namespace clothsim
