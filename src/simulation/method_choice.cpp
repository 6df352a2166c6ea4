#include "clothsim/simulation/method_choice.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <variant>
#include <vector>

#include "clothsim/dynamics/spectrum.h"
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
  double size;     // of the cloth [m]
  double gravity;  // [m/s^2]
  double fastest;  // omega_max [rad/s]
  double axial;    // lowest frequency along the cloth's longer side, hung from one end [rad/s]
  double swing;    // frequency of a sheet that swings about one edge [rad/s]
};

Motion motion_of(const SimulationSpec& spec, const Cloth& cloth) {
  const Eigen::RowVector3d extent =
      cloth.rest_positions.colwise().maxCoeff() - cloth.rest_positions.colwise().minCoeff();
  Motion m;
  m.size = extent.maxCoeff();
  m.gravity = spec.gravity.norm();
  m.fastest = omega_max_bound(cloth, cloth.rest_positions);
  m.axial = m.fastest * M_PI / (4 * std::max(cloth.columns, cloth.rows));
  m.swing = std::sqrt(1.5 * m.gravity / m.size);
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

/// Phase error w t (w h)^2 / 24 of an amplitude: g / w^2 along the cloth, its size as it swings.
double verlet_error(const Motion& m, double h) {
  return horizon * h * h / 24 * (m.gravity * m.axial + m.size * std::pow(m.swing, 3));
}

/// Of fourth order, led by the fast waves: fitted.
double rk4_error(const Motion& m, double h) {
  return 840 * m.gravity * std::pow(m.axial, 1.2) * std::pow(h, 4) * horizon;
}

/// Between first order, where impulses or the start restart it, and second: fitted.
double bdf2_error(const Motion& m, double h) {
  return 0.056 * m.gravity * std::pow(h, 1.3) * horizon;
}

/// One iteration leaves the cloth too soft, the more so the stiffer it is: fitted.
double xpbd_error(const Motion& m, double h) {
  return 0.047 * m.gravity * std::pow(h, 1.5) * std::pow(m.fastest, 0.8) * horizon;
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
               const Motion& motion) {
  const double dt = 1 / spec.frames_per_second;
  const double stability_limit = stability_limit_of(c.method);
  // Explicit methods follow the strain limit's tension, from none on.
  std::optional<double> tension;
  if (std::isfinite(stability_limit)) tension = 0;
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

MethodChoice choose_method(const SimulationSpec& spec, const Cloth& cloth) {
  if (spec.method != "auto") return {spec.method, 1, 0, 0, "named by the scene"};
  if (cloth.springs.empty()) {
    return {VelocityVerlet::name, 1, 0, 0, "no springs to integrate"};
  }

  const Motion motion = motion_of(spec, cloth);
  std::vector<Offer> offers;
  for (const Candidate& c : candidates()) {
    const Offer offer = offer_of(c, spec, cloth, motion);
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
