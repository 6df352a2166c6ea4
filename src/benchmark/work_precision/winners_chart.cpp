// The method that reaches a given error at the least cost, by stiffness and number of points.

#include <cmath>
#include <map>
#include <memory>
#include <set>

#include "chart.h"
#include "clothsim/dynamics/spectrum.h"
#include "clothsim/model/grid.h"
#include "dials.h"
#include "score.h"
#include "table.h"

namespace clothsim::work_precision {
namespace {

constexpr int frames = 6;  // at 200 x 200 points a step is expensive

/// The tightest error that is charted. A run that costs more than twice another run's cost to reach
/// it cannot win and is stopped.
constexpr double tightest = 1e-5;
constexpr double hopeless = 2;
constexpr double longest = 8;  // of any run [CPU s]

struct Cell {
  Trial trial;
  Reference reference;
  double best = infinity;       // cheapest within `tightest`
  std::set<std::string> exact;  // methods within `tightest`
};

/// Measured costs by points a side, stiffness and index in the list of dials. A cloth of twice the
/// points a side has four times the points, so that it costs at least four times as much.
using Costs = std::map<std::tuple<int, double, std::size_t>, double>;

struct Race {
  Table table{{"columns", "ks", "method", "substeps", "iterations", "status", "cost_ms_per_s",
               "position_error", "reference_order", "reference_uncertainty"}};
  Costs costs;
};

Scene scene_of(int side, double ks) {
  Scene scene = corner_drop(side);
  scene.cloth.material.ks = ks;
  return scene;
}

/// Explicit methods from their limit on, the others from one substep on; cheap ones first.
std::vector<Dial> cell_dials(const Scene& scene, bool quick) {
  const Cloth cloth = make_grid(scene.cloth);
  const double angle =  // omega times a frame's duration
      omega_max_bound(cloth, cloth.rest_positions) / scene.simulation.frames_per_second;
  std::vector<Dial> list;
  for (const std::string& method : method_names()) {
    const double limit =
        std::visit([](const auto& m) { return m.stability_limit; }, make_integrator(method));
    if (std::isfinite(limit)) {
      const int least = static_cast<int>(std::ceil(1.05 * angle / limit));
      for (const int factor : {1, 2, 4, 8}) list.push_back({method, factor * least});
    } else if (method == Xpbd::name) {
      for (const int n : {4, 16, 64, 256}) list.push_back({method, n, 1});
    } else {
      for (const int n : quick ? std::vector{1} : std::vector{1, 4, 16}) {
        list.push_back({method, n});
      }
    }
  }
  return list;
}

void add(const Cell& cell, const Dial& dial, const char* status, double cost, double error,
         Race& shared) {
  const ClothSpec& cloth = cell.trial.scene.cloth;
  shared.table.add({cloth.columns, cloth.material.ks, dial.method, dial.substeps.value_or(0),
                    dial.iterations.value_or(1), status, cost, error, cell.reference.order,
                    cell.reference.uncertainty.back()});
}

void race(Cell& cell, const Dial& dial, std::size_t place, Race& shared) {
  if (cell.exact.count(dial.method) > 0) return;  // finer steps only cost more
  const ClothSpec& cloth = cell.trial.scene.cloth;
  const auto key = [&](int side) { return std::make_tuple(side, cloth.material.ks, place); };
  const auto smaller = shared.costs.find(key(cloth.columns / 2));
  if (smaller != shared.costs.end() && 4 * smaller->second > hopeless * cell.best) {
    shared.costs[key(cloth.columns)] = 4 * smaller->second;
    return add(cell, dial, "beaten", Score::none, Score::none, shared);
  }
  const double seconds = frames / cell.trial.scene.simulation.frames_per_second;
  const Budget budget{0.05, std::min(longest, hopeless * cell.best * 1e-3 * seconds)};
  const Run result = run(simulator_of(at(cell.trial.scene, dial)), frames, budget);
  shared.costs[key(cloth.columns)] = result.cost;
  if (result.outcome == Outcome::stopped) {
    return add(cell, dial, "beaten", result.cost, Score::none, shared);
  }
  const double error = score(result, cell.reference, cell.trial).position;
  if (result.outcome == Outcome::done && error <= tightest) {
    cell.best = std::min(cell.best, result.cost);
    cell.exact.insert(dial.method);
  }
  add(cell, dial, name_of(result.outcome), result.cost, error, shared);
}

}  // namespace

std::vector<Job> winners_jobs(const Options& options) {
  auto shared = std::make_shared<Race>();
  std::vector<Job> jobs;
  for (const int side : options.quick ? std::vector{6} : std::vector{25, 50, 100, 200}) {
    for (const double ks :
         options.quick ? std::vector{5e3} : std::vector{5e2, 5e3, 5e4, 5e5, 5e6, 5e7}) {
      auto cell = std::make_shared<Cell>();
      cell->trial = {"corner_drop", scene_of(side, ks), frames, Compared::all_frames, true, 0,
                     false};
      jobs.push_back([=] { cell->reference = make_cheap_reference(cell->trial); });
      const std::vector<Dial> list = cell_dials(cell->trial.scene, options.quick);
      for (std::size_t i = 0; i < list.size(); ++i) {
        if (!wanted(options.methods, list[i].method)) continue;
        if (list[i].substeps > max_substeps) continue;  // more than a scene may have
        jobs.push_back([=] { race(*cell, list[i], i, *shared); });
      }
      jobs.push_back([=] { cell->reference = {}; });  // frees memory: some are large
    }
  }
  jobs.push_back([=] { shared->table.write(options.output / "winners.csv"); });
  return jobs;
}

}  // namespace clothsim::work_precision
