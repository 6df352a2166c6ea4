#include "clothsim/simulation/method_choice.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <variant>
#include <vector>

#include "clothsim/collision/shape.h"
#include "clothsim/dynamics/drag.h"
#include "clothsim/dynamics/spectrum.h"
#include "clothsim/dynamics/springs.h"
#include "clothsim/simulation/substeps.h"

namespace clothsim {
namespace {

/// Share of a core that may go into the cloth: the rest is for those who look at it.
constexpr double real_time_share = 0.9;

/// Horizon of the predicted error [s].
constexpr double horizon = 0.5;

/// CPU time of the strain limit a substep [s] per spring: of finding those at it, and of solving
/// where the cloth's weight brings many there.
constexpr double check_cost = 1.5e-9;
constexpr double solve_cost = 2.5e-9;

/// What errors depend on.
struct Motion {
  double size;      // of the cloth [m]
  double gravity;   // [m/s^2]
  double drag;      // [1/s]
  double fastest;   // omega_max [rad/s]
  double axial;     // lowest frequency along the cloth's longer side, hung from one end [rad/s]
  double swing;     // frequency of a sheet that swings about one edge [rad/s]
  double loaded;    // share of the horizon in which something holds the cloth
  double fallen;    // rms over the horizon of how far it falls before [m]
  double velocity;  // rms over the horizon of its velocity in that fall [m/s]
  double buckling;  // rate at which an upright column that stands on something buckles [1/s]
  double folded;    // rms over the cloth of how far it has folded when that ends [m]
};

/// How far a cloth that nothing holds may fall [m]: to the nearest collider.
double room_below(const Cloth& cloth, const std::vector<ColliderSpec>& colliders) {
  double room = std::numeric_limits<double>::infinity();
  for (const ColliderSpec& collider : colliders) {
    const Eigen::Matrix3d to_shape = collider.pose.orientation.conjugate().toRotationMatrix();
    for (int i = 0; i < cloth.num_points(); ++i) {
      const Vector3 x =
          to_shape * (cloth.rest_positions.row(i).transpose() - collider.pose.position);
      room = std::min(room, signed_distance(collider.shape, x, x).value);
    }
  }
  return std::max(room, 0.0);
}

/// A free cloth falls with drag, v = g (1 - exp(-c t)) / c, until it lands.
void add_fall(double room, Motion& m) {
  constexpr int samples = 50;
  m.loaded = 0;
  double fallen2 = 0;
  double velocity2 = 0;
  double x = 0;
  for (int i = 1; i <= samples; ++i) {
    const double dt = horizon / samples;
    const double v = m.gravity * Drag(m.drag, (i - 0.5) * dt).distance;
    x += dt * v;
    if (x >= room) {
      m.loaded = 1 - (i - 1.0) / samples;
      break;
    }
    fallen2 += x * x / samples;
    velocity2 += v * v / samples;
  }
  m.fallen = std::sqrt(fallen2);
  m.velocity = std::sqrt(velocity2);
}

/// A column that stands on something has no stiffness across: under the weight W above it a link
/// of length a buckles at the rate sqrt(4 W / (m a)), until folds are as deep as links are long,
/// over the part of the cloth that has buckled by then.
void add_buckling(const Cloth& cloth, double height, Motion& m) {
  const double link = shortest_rest_length(cloth);
  if (m.loaded == 0 || height < 0.5 * m.size) return;
  constexpr double unevenness = 1e-3;  // of an upright cloth's start [m]
  constexpr double part = 0.11;        // fitted to one fold, see method.md for others
  m.buckling = 2 * std::sqrt(m.gravity * height) / link;
  m.folded = part * link * std::log(std::max(link / unevenness, M_E));
}

Motion motion_of(const SimulationSpec& spec, const Cloth& cloth,
                 const std::vector<ColliderSpec>& colliders) {
  const Eigen::RowVector3d extent =
      cloth.rest_positions.colwise().maxCoeff() - cloth.rest_positions.colwise().minCoeff();
  Motion m{};
  m.size = extent.maxCoeff();
  m.gravity = spec.gravity.norm();
  m.drag = cloth.damping;
  m.fastest = omega_max_bound(cloth, cloth.rest_positions);
  m.axial = m.fastest * M_PI / (4 * std::max(cloth.columns, cloth.rows));
  m.swing = std::sqrt(1.5 * m.gravity / m.size);
  m.loaded = 1;
  const bool is_free = (cloth.inv_mass.array() > 0).all();
  if (is_free && m.gravity > 0) {
    add_fall(room_below(cloth, colliders), m);
    add_buckling(cloth, std::abs(extent.dot(spec.gravity)) / m.gravity, m);
  }
  return m;
}

/// A method that `auto` may take: the others are worse than one of these at every cost and error
/// (docs/benchmarks.md). Errors [m] over the horizon for a substep of h [s] and CPU seconds a
/// substep are fits to measurements, in the form that theory gives where it does.
struct Candidate {
  const char* method;
  double (*error)(const Motion&, double h);
  double (*cost)(double springs, double points);
};

/// What a method's `error` of the springs of a cloth that is held all the time comes to here.
/// Errors of phase grow with the time under load, and the part of the cloth that waves have reached
/// grows with it: with t^1.5 in all, or t^2 in the mean over the horizon. A fold's rate is off by
/// the share (rate h)^2 / 24; contact leaves no method a better order.
double under_load(const Motion& m, double h, double error) {
  const double of_rate = m.buckling * m.buckling * h * h / 24;
  return m.loaded * m.loaded * (error + of_rate * m.folded);
}

/// Phase error w t (w h)^2 / 24 of an amplitude: g / w^2 along the cloth, its size as it swings;
/// and the share (c h)^2 / 24 by which drag and gravity, taken in turn, miss the speed of a fall.
/// The first factor is that of cloths held by an edge (0.35) and by two corners (0.55 to 1.25).
double verlet_error(const Motion& m, double h) {
  const double phase = horizon * h * h / 24 * (m.gravity * m.axial + m.size * std::pow(m.swing, 3));
  return under_load(m, h, 0.65 * phase) + m.drag * m.drag * h * h / 24 * m.fallen;
}

/// Of fourth order, led by the fast waves: fitted.
double rk4_error(const Motion& m, double h) {
  const double waves = 840 * m.gravity * std::pow(m.axial, 1.2) * std::pow(h, 4) * horizon;
  return under_load(m, h, waves);
}

/// Between first order, where impulses or the start restart it, and second: fitted. The first step
/// of a fall, implicit Euler's, puts it half a step ahead.
double bdf2_error(const Motion& m, double h) {
  const double held = 0.056 * m.gravity * std::pow(h, 1.3) * horizon;
  return under_load(m, h, held) + (m.fallen > 0 ? m.gravity * h * h / 2 : 0);
}

/// One iteration leaves the cloth too soft, the more so the stiffer it is: fitted. A fall is half a
/// step ahead.
double xpbd_error(const Motion& m, double h) {
  const double held = 0.047 * m.gravity * std::pow(h, 1.5) * std::pow(m.fastest, 0.8) * horizon;
  return under_load(m, h, held) + h / 2 * m.velocity;
}

const std::vector<Candidate>& candidates() {
  static const std::vector<Candidate> all = {
      {VelocityVerlet::name, verlet_error, [](double s, double) { return 1.8e-9 * s; }},
      {RungeKutta4::name, rk4_error, [](double s, double) { return 7e-9 * s; }},
      {Xpbd::name, xpbd_error, [](double s, double) { return 6.3e-9 * s; }},
      // Two factorisations of the grid's matrix a step.
      {Bdf2::name, bdf2_error, [](double, double p) { return 0.8e-6 * std::pow(p, 1.5); }},
  };
  return all;
}

double limit_cost(const SimulationSpec& spec, const Cloth& cloth) {
  if (!cloth.strain_limit) return 0;
  const SpringRun& run = cloth.springs.front();
  const double strength = run.stiffness * *cloth.strain_limit * run.rest_length * cloth.columns;
  const double weight = cloth.mass.sum() * spec.gravity.norm();
  const double share = weight < strength ? weight / strength : 1;
  return (check_cost + share * solve_cost) * cloth.num_springs();
}

/// A candidate with the substeps it would take.
struct Offer {
  const Candidate* candidate;
  int substeps;
  double error;  // of the cloth's size
  double cost;   // CPU seconds a simulated second
  bool stable;
  bool accurate;
  bool real_time() const { return cost <= real_time_share; }
};

double stability_limit_of(const std::string& method) {
  return std::visit([](const auto& m) { return m.stability_limit; }, make_integrator(method));
}

Offer offer_of(const Candidate& c, const SimulationSpec& spec, const Cloth& cloth,
               const Motion& motion, bool touches) {
  const double dt = 1 / spec.frames_per_second;
  const double stability_limit = stability_limit_of(c.method);
  // Explicit methods follow the strain limit's tension, from none on.
  std::optional<Tension> tension;
  if (std::isfinite(stability_limit)) tension = Tension{0, touches};
  const int needed =
      count_substeps(cloth, spec.gravity, cloth.rest_positions, stability_limit, dt, tension);
  const auto error = [&](int n) { return c.error(motion, dt / n) / motion.size; };
  const double step_cost =
      c.cost(cloth.num_springs(), cloth.num_points()) + limit_cost(spec, cloth);
  const auto cost = [&](int n) { return n * spec.frames_per_second * step_cost; };

  int n = needed;
  if (spec.substeps) {
    n = *spec.substeps;
  } else {
    // As many as the tolerance asks for and real time allows.
    const int affordable = static_cast<int>(std::clamp(
        real_time_share / cost(1), static_cast<double>(needed), static_cast<double>(max_substeps)));
    while (error(n) > spec.tolerance && n < affordable) n = std::min(n + (n + 7) / 8, affordable);
  }
  const bool stable = n < max_substeps && motion.fastest * dt / n < stability_limit;
  return {&c, n, error(n), cost(n), stable, error(n) <= spec.tolerance};
}

MethodChoice choice_of(const Offer& offer, std::string reason) {
  return {offer.candidate->method, offer.substeps, offer.error, offer.cost, std::move(reason)};
}

}  // namespace

MethodChoice choose_method(const SimulationSpec& spec, const Cloth& cloth,
                           const std::vector<ColliderSpec>& colliders) {
  if (spec.method != "auto") return {spec.method, 1, 0, 0, "named by the scene"};
  if (cloth.springs.empty()) {
    return {VelocityVerlet::name, 1, 0, 0, "no springs to integrate"};
  }

  const Motion motion = motion_of(spec, cloth, colliders);
  const bool touches = cloth.self_collision != SelfCollision::off || !colliders.empty();
  std::vector<Offer> offers;
  for (const Candidate& c : candidates()) {
    const Offer offer = offer_of(c, spec, cloth, motion, touches);
    if (offer.stable) offers.push_back(offer);
  }
  if (offers.empty()) {
    return {VelocityVerlet::name, 1, 0, 0, "no method is stable with so few substeps"};
  }

  const auto cheaper = [](const Offer& a, const Offer& b) { return a.cost < b.cost; };
  const auto finer = [](const Offer& a, const Offer& b) { return a.error < b.error; };
  const auto best_of = [&](auto is_wanted, auto better) -> std::optional<Offer> {
    std::optional<Offer> best;
    for (const Offer& offer : offers) {
      if (is_wanted(offer) && (!best || better(offer, *best))) best = offer;
    }
    return best;
  };

  if (auto o = best_of([](const Offer& a) { return a.accurate && a.real_time(); }, cheaper)) {
    return choice_of(*o, "the cheapest within tolerance");
  }
  if (auto o = best_of([](const Offer& a) { return a.real_time(); }, finer)) {
    return choice_of(*o, "none is within tolerance in real time: the most accurate in real time");
  }
  return choice_of(*best_of([](const Offer&) { return true; }, cheaper),
                   "none is in real time: the cheapest");
}

}  // namespace clothsim
