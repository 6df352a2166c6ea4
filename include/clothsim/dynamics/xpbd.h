#pragma once

#include <array>
#include <tuple>
#include <vector>

#include "clothsim/dynamics/bends.h"
#include "clothsim/dynamics/cells.h"
#include "clothsim/dynamics/cloth_watch.h"
#include "clothsim/dynamics/forces.h"
#include "clothsim/dynamics/xpbd_lines.h"
#include "clothsim/model/checks.h"
#include "clothsim/model/cloth.h"
#include "clothsim/model/state.h"

namespace clothsim {

/// Extended position based dynamics: implicit Euler solved by constraints, Gauss-Seidel on their
/// multipliers lambda. That of a spring alone has dlambda = (-C - a lambda) / (w_1 + w_2 + a) with
/// C = l - L0 and a = 1 / (k h^2). Macklin et al. 2016, "XPBD"; small steps with one iteration each
/// rather than many iterations: Macklin et al. 2019, "Small steps in physics simulation".
///
/// The springs of a grid are solved in lines, see XpbdLines.
///
/// Multipliers start at zero in each step and are kept over its iterations. Passes over other
/// constraints go by colour, no two of a colour sharing a point. An iteration goes forth and back
/// (symmetric Gauss-Seidel): one that goes forth alone can feed fast waves, and stiff cloth
/// trembles for ever. Drag as in implicit Euler.
///
/// As published, corrections do not follow the turns of their springs in later passes, and the
/// limit of many iterations is not quite implicit Euler's. So each iteration but the first moves
/// points to the places that the multipliers give with the springs' present directions.
///
/// A strain of a fabric's cell is a constraint, see CellRun. A triangle of a mesh is a constraint
/// on the squared lengths of its edges, see TriangleFabric. A bend is a constraint on the three
/// components of its stencil; those of a triangle are solved together, see PatchBend. Internal
/// damping makes constraints stiffer, towards their values at the step's start: see DampedSpring.
/// That of a bend that is curved at rest is a constraint of its own, linear in the positions.
class Xpbd {
 public:
  static constexpr const char* name = "xpbd";
  enum { order = 1 };
  static constexpr double stability_limit = infinity;
  static double displacement_factor(double, double) { return 1; }  // see Integrator

  struct Parameters {
    int iterations = 1;

    template <typename Self, typename Visit>
    static void each(Self& self, Visit&& visit) {
      visit("iterations", self.iterations, Range{1, 100000, ""});
    }
  };

  Xpbd() : Xpbd(Parameters()) {}
  explicit Xpbd(const Parameters& parameters) : parameters_(parameters) {}

  /// Advances positions and velocities by h [s]; the caller keeps the time.
  void step(const Cloth&, const Loads&, double h, State&, const Workers& = {});

  /// Adds the impulses of all constraints on held points in the last step, of h [s] [N s, N x 3],
  /// as forces through the step. With these momentum balances with one iteration, however long the
  /// step; with more, as far as they converge. The forces of the springs at the step's end are
  /// larger, by the residual of the step.
  void add_reactions(const Cloth&, double h, Points& impulses) const;

  static constexpr bool unconverged() { return false; }  // see Integrator

 private:
  /// A triangle of a mesh.
  struct MembraneConstraint {
    std::array<int, 3> corners;
    Vector3 rest2;              // Q [m^2]
    Eigen::Matrix3d stiffness;  // h^2 K [kg/m^2], with internal damping
    Vector3 target;             // [m^2], of a step: Q without internal damping
    Vector3 lambda;
  };
  /// A strain of a cell.
  struct CellConstraint {
    Cell cell;
    double compliance;  // as above [1/J]
    double target;      // of a step
    double lambda;
  };
  /// A bend of a grid.
  struct BendConstraint {
    Bend bend;
    double compliance;  // as above
    double share;       // 1 / (sum of w times squared coefficient + compliance)
    Vector3 target;     // [m], of a step
    Vector3 lambda;
  };
  /// The bends of a triangle that are flat at rest, solved at once: one in a row, along an axis in
  /// a column. `size`: of its points, as many as any of these bends has.
  template <int size>
  struct PatchConstraint {
    std::array<int, size> points;
    Eigen::Matrix<double, 3, size> coefficients;  // [1/m^2]; 0 in rows without a bend
    Vector3 compliance;                           // as above
    Eigen::Matrix3d inverse;                      // of C w C^T + compliance
    Eigen::Matrix3d target;                       // [1/m], of a step
    Eigen::Matrix3d lambda;
  };
  /// Derivatives of b - B n by the points of a bend [1/m^2].
  using Derivatives = std::array<Eigen::Matrix3d, PatchBend::near>;
  /// A bend that is curved at rest, and its damping: the constraint that the sum of at_frame_i x_i
  /// is the target.
  struct CurvedConstraint {
    PatchBend bend;
    double compliance;
    Vector3 lambda;
    double damping_compliance;  // infinite without damping
    Vector3 damping_lambda;
    Derivatives at_frame;  // at Past::frame of a step
    Vector3 target;        // of a step [1/m]

    bool is_damped() const { return std::isfinite(damping_compliance); }
  };

  /// Constraints by colour.
  template <typename Constraint>
  struct Coloured {
    std::vector<Constraint> list;
    std::vector<int> colour_ends;  // in `list`
  };
  /// Calls visit(patches) for those of each size.
  template <typename Patches, typename Visit>
  static void for_each_size(Patches& all, const Visit& visit) {
    std::apply([&](auto&... of_size) { (visit(of_size), ...); }, all);
  }
  void build(const Cloth&, double h);
  void build_cells(const Cloth&, double h);
  void build_membranes(const Cloth&, double h);
  void build_bends(const Cloth&, double h);
  void build_patches(const Cloth&, double h);
  void build_curved(const Cloth&, double h);
  void set_targets(const Cloth&, double h, const Points& positions);
  void set_curved_frames();
  void set_curved_targets();
  void set_bend_targets(const Cloth&, double h, const Points& displacements, const Workers&);
  void set_patch_targets(const Cloth&, double h);
  void solve_membranes(const Cloth&, bool back, Points& positions, const Workers&);
  void solve_bends(const Cloth&, bool back, Points& positions, const Workers&);
  void solve_patches(const Cloth&, bool back, Points& positions, const Workers&);
  template <typename Patches>
  void solve_patches(const Cloth&, bool back, Patches&, Points& positions, const Workers&);
  void solve_curved(const Cloth&, bool back, Points& positions, const Workers&);
  void solve_curved(const Cloth&, const PatchBend&, const Derivatives&, const Vector3& residual,
                    double compliance, Vector3& lambda, Points& positions);
  void solve_cells(const Cloth&, bool back, Points& positions, const Workers&);
  void pull(const Cloth&, int i, const Eigen::RowVector3d& correction);
  void pull_by_springs(const Cloth&, const Points& positions);
  void pull_by_cells(const Cloth&, const Points& positions);
  void pull_by_membranes(const Cloth&, const Points& positions);
  void pull_by_bends(const Cloth&);
  void pull_by_patches(const Cloth&);
  void pull_by_curved(const Cloth&, const Points& positions);
  void realign(const Cloth&, Points& positions);
  void react(const Cloth& cloth, int i, const Eigen::RowVector3d& correction) {
    if (cloth.inv_mass[i] == 0) reactions_.row(i) += correction;
  }

  Parameters parameters_;
  ClothWatch watch_;
  XpbdLines springs_;
  Coloured<CellConstraint> cells_;
  Coloured<MembraneConstraint> membranes_;
  Coloured<BendConstraint> bends_;  // of a grid
  // For a mesh, those of fewer points first.
  std::tuple<Coloured<PatchConstraint<PatchBend::near>>, Coloured<PatchConstraint<PatchBend::size>>>
      patches_;
  Coloured<CurvedConstraint> curved_;
  Points reactions_;  // sums of corrections on held points [kg m], N x 3
  Points past_;       // positions before the step [m], N x 3; with damped bends
  Points frame_;      // see Past; the same
  Points turned_;     // past_, turned with the cloth; the same
  Points start_;      // positions before the passes [m], N x 3
  Points target_;     // of points, by the multipliers [m], N x 3
  Scalars turn_;      // stiffness against turning, times inverse mass, N
};

}  // namespace clothsim
