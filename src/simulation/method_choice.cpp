#include "clothsim/simulation/method_choice.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "clothsim/constraints/contact_step.h"
#include "clothsim/constraints/local_cloth.h"
#include "clothsim/dynamics/drag.h"
#include "clothsim/dynamics/spectrum.h"
#include "clothsim/dynamics/springs.h"
#include "clothsim/model/grid.h"
#include "clothsim/shapes/shape.h"
#include "clothsim/simulation/cloth_size.h"
#include "clothsim/simulation/substeps.h"
#include "xpbd_stretch.h"

namespace clothsim {
namespace {

/// Horizon of the predicted error [s].
constexpr double horizon = 0.5;

/// CPU time [s] of impulses per substep and point, for a cloth that lies or has folded.
/// `point_cost`: where points alone touch a collider or each other, or the cloth's weight brings
/// half of the springs to their limit; `surface_cost`: where triangles and edges touch, too.
/// Measured by `clothsim_benchmark --benchmark_filter=_step`, which repeats to a factor 1.5. Out of
/// reach contact costs next to nothing, in an impact several times as much: with these numbers
/// methods can be ranked by cost, but not compared with real time.
constexpr double point_cost = 1.6e-8;
constexpr double surface_cost = 1.3e-7;

/// Costs that differ by up to this factor count as equal, given the accuracy of the costs above.
constexpr double alike = 1.5;

/// Quantities on which errors depend.
struct Motion {
  double size;       // of the cloth [m]
  double gravity;    // [m/s^2]
  double drag;       // [1/s]
  double omega_max;  // bound on the highest frequency of the springs [rad/s]
  double axial;      // lowest frequency along the cloth's longer side, hung from one end [rad/s]
  double swing;      // frequency of a sheet that swings about one edge [rad/s]
  double loaded;     // share of the horizon in which something holds the cloth
  bool held;         // whether something holds the cloth, now or later
  double buckling;   // buckling rate of an upright column that stands on something [1/s]
  double folded;     // rms of the fold depth over the cloth at the end of buckling [m]
  bool rings;        // whether the cloth has fast waves, in which errors grow
  double cells;      // along the cloth's longer side
  bool only_lines;   // whether XPBD solves whole lines of springs, and nothing else acts
};

/// Height from which a free cloth falls [m]: to the nearest collider.
double fall_height(const Cloth& cloth, const std::vector<ColliderSpec>& colliders) {
  double height = infinity;
  for (const ColliderSpec& collider : colliders) {
    const Pose pose = collider.pose * collider.offset;
    const Eigen::Matrix3d to_shape = pose.orientation.conjugate().toRotationMatrix();
    for (int i = 0; i < cloth.num_points(); ++i) {
      const Vector3 x = to_shape * (cloth.rest_positions.row(i).transpose() - pose.position);
      height = std::min(height, signed_distance(collider.shape, x, x).value);
    }
  }
  return std::max(height, 0.0);
}

/// A free cloth falls with drag, exactly in all methods, until it lands. Returns the share of the
/// horizon that is left then, in frames of `frame` [s].
double share_after_fall(double height, double frame, const Motion& m) {
  const int samples = static_cast<int>(std::ceil(horizon / frame));
  for (int i = 1; i <= samples; ++i) {
    if (m.gravity * Drag(m.drag, i * horizon / samples).fall >= height) {
      return 1 - (i - 1.0) / samples;
    }
  }
  return 0;
}

/// A column that stands on something has no stiffness across: under the weight W above it a link of
/// length a buckles at the rate sqrt(4 W / (m a)), until folds are as deep as links are long, over
/// the part of the cloth that has buckled by then.
void add_buckling(const Cloth& cloth, double height, Motion& m) {
  const double link = shortest_rest_length(cloth);
  if (m.loaded == 0 || height < 0.5 * m.size) return;
  constexpr double part = 0.11;  // fitted to one fold, see docs/experiments.md
  m.buckling = 2 * std::sqrt(m.gravity * height) / link;
  m.folded = part * link * std::log(std::max(link / unevenness(cloth), M_E));
}

/// A held cloth bends as it comes down. Where omega_max t times g t^2 / L, the angle of the bend,
/// exceeds this, a stiff cloth rings with fast waves, in which errors grow by a factor of 3 to 100.
/// Errors of nearly equal scenes differ by a factor of ten there, so no error is predicted. The
/// number is measured.
constexpr double onset = 30000;

bool has_impulses(const Cloth& cloth, const std::vector<ColliderSpec>& colliders) {
  return cloth.strain_limit || cloth.self_collision != SelfCollision::off || !colliders.empty();
}

Motion motion_of(const SimulationSpec& spec, const Cloth& cloth,
                 const std::vector<ColliderSpec>& colliders) {
  const Eigen::RowVector3d extent = extent_of(cloth);
  Motion m{};
  m.size = extent.maxCoeff();
  m.gravity = spec.gravity.norm();
  m.drag = cloth.damping;
  m.omega_max = omega_max_bound(cloth, cloth.rest_positions);
  m.cells = cells_along(cloth);
  m.only_lines = !cloth.is_mesh() && !has_impulses(cloth, colliders);
  m.axial = m.omega_max * M_PI / (4 * m.cells);
  m.swing = std::sqrt(1.5 * m.gravity / m.size);
  m.loaded = 1;
  m.held = true;
  const bool is_free = (cloth.inv_mass.array() > 0).all();
  if (!is_free) {
    m.rings = m.omega_max * horizon * m.gravity * horizon * horizon / m.size > onset;
  } else if (m.gravity > 0) {
    const double height = fall_height(cloth, colliders);
    m.held = std::isfinite(height);
    m.loaded = share_after_fall(height, 1 / spec.frames_per_second, m);
    add_buckling(cloth, std::abs(extent.dot(spec.gravity)) / m.gravity, m);
  }
  return m;
}

/// A method that `auto` may take: the others are worse than one of these at every cost and error
/// (docs/benchmarks.md). A method that handles impulses of contact and the strain limit badly is
/// taken where springs alone act. Errors [m] over the horizon for a substep of h [s], and CPU
/// seconds per substep of omega_h = omega_max h, are fits to measurements, of a theoretical form
/// where there is one.
struct Candidate {
  const char* method;
  bool takes_impulses;
  bool damps_fast_waves;
  bool softens;  // makes springs too soft, which hardly shows in the error of positions
  double (*error)(const Motion&, double h);
  double (*cost)(double springs, double points, double omega_h);
};

/// Error in this scene from the `error` of springs in a cloth that is held all the time. Phase
/// errors grow with the time under load, and with them the part of the cloth that waves have
/// reached: as t^1.5 in total, or t^2 in the mean over the horizon. A fold's rate has a relative
/// error of (rate h)^2 / 24; with contact no method has a better order.
double under_load(const Motion& m, double h, double error) {
  const double of_rate = m.buckling * m.buckling * h * h / 24;
  return m.loaded * m.loaded * (error + of_rate * m.folded);
}

/// Phase error w t (w h)^2 / 24 of an amplitude: g / w^2 along the cloth, its size as it swings. A
/// fall is exact. The factor is that of cloths held by an edge (0.35) and by two corners (0.55 to
/// 1.25).
double verlet_error(const Motion& m, double h) {
  const double phase = horizon * h * h / 24 * (m.gravity * m.axial + m.size * std::pow(m.swing, 3));
  return under_load(m, h, 0.65 * phase);
}

/// Fourth order, dominated by the fast waves: fitted. In its stages a held cloth falls by a whole
/// step before impulses correct it: it hangs 2 mm off at two substeps a frame, and on a sphere it
/// creeps at some mm/s for ever.
double rk4_error(const Motion& m, double h) {
  const double waves = 840 * m.gravity * std::pow(m.axial, 1.2) * std::pow(h, 4) * horizon;
  return under_load(m, h, waves);
}

/// Between first order, where impulses or the start restart it, and second: fitted.
double bdf2_error(const Motion& m, double h) {
  return under_load(m, h, 0.056 * m.gravity * std::pow(h, 1.3) * horizon);
}

/// One iteration leaves the cloth too soft, the more so the stiffer it is: fitted, for lines within
/// a factor of two at omega h of 0.3 to 190; otherwise for springs one by one, as in a mesh, which
/// is too large for a grid in contact. The error does not shrink if the cloth lands late.
double xpbd_error(const Motion& m, double h) {
  if (!m.held) return 0;
  const double of_lines =
      0.12 + 0.05 * std::pow(m.omega_max * h, 0.7) * std::pow(m.cells / 50, 1.3);
  const double otherwise = 0.035 * std::pow(h, 0.5) * std::pow(m.omega_max, 0.8);
  return m.gravity * h * horizon * (m.only_lines ? of_lines : otherwise);
}

/// Two Newton steps by conjugate gradients, whose steps grow with omega h, the square root of the
/// condition number, up to a multiple of the points along the cloth. Fitted within a factor of
/// four to cloths of 10 x 10 to 100 x 100 points and strips of 3 x 51, at omega h of 3 to 15000.
double bdf2_cost(double, double points, double omega_h) {
  return points * (1.5e-6 + std::min(6e-8 * std::pow(omega_h, 0.9), 5e-7 * std::sqrt(points)));
}

const std::vector<Candidate>& candidates() {
  static const std::vector<Candidate> all = {
      {VelocityVerlet::name, true, false, false, verlet_error,
       [](double s, double, double) { return 0.9e-9 * s; }},
      {RungeKutta4::name, false, false, false, rk4_error,
       [](double s, double, double) { return 3.8e-9 * s; }},
      {Xpbd::name, true, true, true, xpbd_error,
       [](double s, double, double) { return 1.9e-8 * s; }},
      {Bdf2::name, false, true, false, bdf2_error, bdf2_cost},
  };
  return all;
}

double cost_of_contact(const Cloth& cloth, const std::vector<ColliderSpec>& colliders) {
  double cost = 0;
  for (const ColliderSpec& collider : colliders) {
    cost += clearance(collider.shape, cloth).faces ? surface_cost : point_cost;
  }
  if (cloth.self_collision == SelfCollision::points) cost += point_cost;
  if (cloth.self_collision == SelfCollision::surface) cost += surface_cost;
  return cost * cloth.num_points();
}

/// Substeps per frame that the cloth needs with a method of this stability limit, whatever the
/// state.
int usual_substeps(double stability_limit, const SimulationSpec& spec, const Cloth& cloth,
                   const std::vector<ColliderSpec>& colliders) {
  const double dt = 1 / spec.frames_per_second;
  const int needed = count_substeps(cloth, spec.gravity, cloth.rest_positions, stability_limit, dt);
  const bool is_free = !cloth.has_forces() || !has_impulses(cloth, colliders);
  if (is_free) return needed;
  const double limit = max_substeps - 1;  // no scene is refused for a low frame rate
  return std::max(needed, static_cast<int>(std::min(std::ceil(dt / longest_step), limit)));
}

/// A candidate with its number of substeps.
struct Offer {
  const Candidate* candidate;
  int substeps;
  std::optional<double> error;  // of the cloth's size
  bool is_explicit;
  double cost;  // CPU seconds a simulated second
  bool stable;
  bool accurate;
  bool real_time;
};

double stability_limit_of(const std::string& method) {
  return std::visit([](const auto& m) { return m.stability_limit; }, make_integrator(method));
}

/// Empty where the motion of the cloth cannot be predicted.
std::optional<double> error_of(const Candidate& c, const Motion& m, double h) {
  if (m.gravity == 0 || (m.rings && !c.damps_fast_waves)) return {};
  return c.error(m, h) / m.size;
}

Offer offer_of(const Candidate& c, const SimulationSpec& spec, const Cloth& cloth,
               const std::vector<ColliderSpec>& colliders, const Motion& motion) {
  const double dt = 1 / spec.frames_per_second;
  const double stability_limit = stability_limit_of(c.method);
  const int needed = usual_substeps(stability_limit, spec, cloth, colliders);
  const auto is_off = [&](int n) {
    return error_of(c, motion, dt / n).value_or(0) > spec.tolerance;
  };
  const auto step_cost = [&](int n) {  // without contact
    return c.cost(cloth.num_links(), cloth.num_points(), motion.omega_max * dt / n) +
           (cloth.strain_limit ? point_cost * cloth.num_points() : 0);
  };
  const auto is_affordable = [&](int n) { return n * spec.frames_per_second * step_cost(n) <= 1; };

  int n = needed;
  if (spec.substeps) {
    n = *spec.substeps;
  } else {
    // As many as the tolerance requires and real time allows.
    for (int next = n; is_off(n) && next < max_substeps; n = next) {
      next = std::min(n + (n + 7) / 8, int{max_substeps});
      if (!is_affordable(next)) break;
    }
  }
  const std::optional<double> error = error_of(c, motion, dt / n);
  const bool stable = n < max_substeps && motion.omega_max * dt / n < stability_limit;
  const double steps = n * spec.frames_per_second;
  const double cost = steps * (step_cost(n) + cost_of_contact(cloth, colliders));
  return {&c,
          n,
          error,
          std::isfinite(stability_limit),
          cost,
          stable,
          error && !is_off(n),
          is_affordable(n)};
}

/// The choice of the scene. Its cost is that of the candidate with similar steps: implicit methods
/// solve systems, explicit ones sum forces.
MethodChoice named_choice(const SimulationSpec& spec, const Cloth& cloth,
                          const std::vector<ColliderSpec>& colliders) {
  const double limit = stability_limit_of(spec.method);
  MethodChoice choice{spec.method, usual_substeps(limit, spec, cloth, colliders),
                      Reason::named_by_scene};
  const auto steps_alike = [&](const Candidate& c) {
    if (spec.method == ImplicitEuler::name) return c.method == Bdf2::name;
    if (spec.method == SymplecticEuler::name) return c.method == VelocityVerlet::name;
    return c.method == spec.method;
  };
  const auto candidate = std::find_if(candidates().begin(), candidates().end(), steps_alike);
  assert(candidate != candidates().end());
  const double steps = spec.frames_per_second * spec.substeps.value_or(choice.min_substeps);
  const double omega_h = omega_max_bound(cloth, cloth.rest_positions) / steps;
  choice.predicted_cost = steps * candidate->cost(cloth.num_links(), cloth.num_points(), omega_h);
  choice.is_feasible = *choice.predicted_cost <= 1;
  return choice;
}

bool cheaper(const Offer& a, const Offer& b) { return a.cost < b.cost; }

bool finer(const Offer& a, const Offer& b) { return a.error < b.error; }

/// Explicit methods conserve energy and momenta, and methods that soften springs are off by any
/// factor where nothing is known of their error.
bool explicit_or_stiff(const Offer& a, const Offer& b) {
  if (a.is_explicit != b.is_explicit) return a.is_explicit;
  const bool softens = a.candidate->softens;
  return softens != b.candidate->softens ? !softens : cheaper(a, b);
}

using Offers = std::vector<Offer>::iterator;

template <bool (*is_better)(const Offer&, const Offer&)>
Offers best(Offers begin, Offers end) {
  return std::min_element(begin, end, is_better);
}

/// The cheapest; where that softens springs, one of about the same cost that does not.
Offers cheapest_and_stiff(Offers begin, Offers end) {
  const Offers cheapest = best<cheaper>(begin, end);
  if (!cheapest->candidate->softens) return cheapest;
  const double max_cost = alike * cheapest->cost;
  const Offers stiff = std::stable_partition(
      begin, end, [=](const Offer& o) { return o.cost <= max_cost && !o.candidate->softens; });
  return best<cheaper>(begin, stiff == begin ? end : stiff);
}

/// The first rule that fits any offer applies: its best offer is taken.
struct Rule {
  Reason reason;
  bool (*is_for)(const Offer&);
  Offers (*best_of)(Offers, Offers);
};

constexpr Rule rules[] = {
    {Reason::error_not_predicted, [](const Offer& o) { return !o.error && o.real_time; },
     best<explicit_or_stiff>},
    {Reason::cheapest_within_tolerance, [](const Offer& o) { return o.accurate && o.real_time; },
     cheapest_and_stiff},
    {Reason::most_accurate_in_real_time, [](const Offer& o) { return o.real_time; }, best<finer>},
    {Reason::none_in_real_time, [](const Offer&) { return true; }, best<cheaper>},
};

MethodChoice choice_among(std::vector<Offer> offers) {
  for (const Rule& rule : rules) {
    const auto end = std::stable_partition(offers.begin(), offers.end(), rule.is_for);
    if (end == offers.begin()) continue;
    const Offer& taken = *rule.best_of(offers.begin(), end);
    return {taken.candidate->method, taken.substeps, rule.reason,
            taken.real_time,         taken.error,    taken.cost};
  }
  return {VelocityVerlet::name, 1, Reason::none_stable, false};
}

/// Adds how far XPBD stretches a cloth whose springs have no limit, where that shows.
MethodChoice with_stretch_told(MethodChoice choice, const SimulationSpec& spec, const Cloth& cloth,
                               bool over_colliders) {
  if (choice.method != Xpbd::name) return choice;
  const int substeps = spec.substeps.value_or(choice.min_substeps);
  if (const auto text = xpbd_stretch_text(spec, cloth, over_colliders, substeps)) {
    choice.reasons.add(Reason::softens, *text);
  }
  return choice;
}

}  // namespace

MethodChoice choose_method(const SimulationSpec& spec, const Cloth& cloth,
                           const std::vector<ColliderSpec>& colliders) {
  if (spec.method != "auto") {
    return with_stretch_told(named_choice(spec, cloth, colliders), spec, cloth, !colliders.empty());
  }
  if (!cloth.has_forces()) {
    return {VelocityVerlet::name, 1, Reason::no_springs, true, 0.0, 0.0};
  }
  const Motion motion = motion_of(spec, cloth, colliders);
  std::vector<Offer> offers;
  for (const Candidate& c : candidates()) {
    if (has_impulses(cloth, colliders) && !c.takes_impulses) continue;
    const Offer offer = offer_of(c, spec, cloth, colliders, motion);
    if (offer.stable) offers.push_back(offer);
  }
  return with_stretch_told(choice_among(std::move(offers)), spec, cloth, !colliders.empty());
}

}  // namespace clothsim
