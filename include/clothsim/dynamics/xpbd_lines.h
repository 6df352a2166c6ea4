#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "clothsim/model/cloth.h"
#include "clothsim/model/lanes.h"
#include "clothsim/model/types.h"
#include "clothsim/model/workers.h"

namespace clothsim {

/// Numbers of lines side by side, see lanes.h.
using Lanes = std::array<double, num_lanes>;
using LanePoints = std::array<int, num_lanes>;

/// The springs of a grid as constraints of Xpbd, in lines: rows, columns, and in a classic cloth
/// diagonals. The multipliers of a line are solved at once, a tridiagonal system (Han & Harada
/// 2013, "Tridiagonal matrix formulation for inextensible hair strand simulation"): with the
/// springs' directions u, inverse masses w of their ends and compliances a,
///   (w_k + w_k+1 + a_k) dlambda_k - w_k u_k-1 . u_k dlambda_k-1 - w_k+1 u_k . u_k+1 dlambda_k+1
///     = target_k - l_k - a_k lambda_k .
/// So the weight of a column reaches its top in one pass. Spring by spring it climbs by a few rows,
/// and few substeps leave a cloth far too soft.
///
/// Tensions -dlambda act in the directions that the springs have after the pass, by their force
/// densities q = -dlambda / l (Schek 1974, "The force density method for form finding and
/// computation of general networks"), a second tridiagonal system, for the points. In the
/// directions before the pass taut lines would shake where the step is long beside the waves across
/// them. Pressures act in the directions before the pass. Impulses stay equal and opposite.
class XpbdLines {
 public:
  /// For steps of h [s].
  void build(const Cloth&, double h);
  void clear();
  /// Sets the targets, between the rest lengths and those at `positions`: see DampedSpring.
  void set_targets(const Points& positions, double damping, double h);
  void begin_step();  // with multipliers of 0
  /// A pass over all lines, direction after direction; `back`: from the last one on. Adds
  /// corrections on points without inverse mass to `reactions` [kg m], N x 3.
  void solve(bool back, Points& positions, Points& reactions, const Workers&);

  /// Calls visit(a, b, lambda) for each spring.
  template <typename Visitor>
  void for_each(Visitor&& visit) const {
    for (const Bundle& bundle : bundles_) {
      for (std::size_t k = 0; k < bundle.lambda.size(); ++k) {
        for (std::size_t lane = 0; lane < bundle.lines; ++lane) {
          visit(bundle.points[k][lane], bundle.points[k + 1][lane], bundle.lambda[k][lane]);
        }
      }
    }
  }

 private:
  /// Lines of equal length side by side. Lanes beyond the last line repeat the first one.
  struct Bundle {
    std::size_t lines;
    std::vector<LanePoints> points;  // along the lines, one more than springs
    std::vector<Lanes> inv_mass;     // of points [1/kg]
    std::vector<Lanes> rest_length;  // of springs [m]
    std::vector<Lanes> compliance;   // 1 / (k h^2) [m/J]
    std::vector<Lanes> target;       // of a step [m]
    std::vector<Lanes> lambda;
    bool is_held;  // has points without inverse mass

    std::size_t springs() const { return target.size(); }
  };
  struct Scratch;

  static void solve(Bundle&, Points& positions, Points& reactions, Scratch&);
  static void react(const Bundle&, const Scratch&, Points& reactions);

  std::vector<Bundle> bundles_;
  std::vector<int> direction_ends_;  // in bundles_
};

}  // namespace clothsim
