// Error against CPU time for every method on each scene.

#include <cmath>
#include <cstdio>
#include <map>
#include <memory>
#include <optional>

#include "chart.h"
#include "dials.h"
#include "peers.h"
#include "score.h"
#include "table.h"
#include "verdict.h"

namespace clothsim::work_precision {
namespace {

/// Position error beyond which a run counts as failed even with finite numbers: it is useless.
constexpr double lost = 0.5;

/// One minute of CPU a run, in case a method does worse than expected.
constexpr Budget run_budget{0.5, 60};

struct Tables {
  Table runs{{"scene",          "columns",        "method",       "used_method",
              "substeps",       "iterations",     "status",       "cost_ms_per_s",
              "repeats",        "position_error", "position_max", "velocity_error",
              "energy_error",   "momentum_error", "centre_error", "worst_stretch",
              "p99_stretch",    "solver_error",   "scheme_error", "horizon_s",
              "predicted_error"}};
  Table references{{"scene", "columns", "rows", "compared", "seconds", "substeps", "smooth",
                    "order", "cross_check", "uncertainty", "twin_growth", "horizon_s",
                    "own_error"}};
  Table choices{{"scene", "method", "cost_ms_per_s", "position_error", "predicted_error",
                 "passed_over", "its_cost_ms_per_s", "its_position_error"}};
};

/// A trial's reference, made by its first job, and the converged runs of iterative schemes.
struct Judge {
  explicit Judge(const Trial& t) : trial(t) {}

  const Trial trial;
  Reference reference;
  std::map<std::pair<std::string, int>, Trajectory> converged_runs;
  std::optional<Contender> chosen;       // of `auto`
  double predicted_error = Score::none;  // of `auto`
  std::vector<Contender> others;

  /// The run of the same scheme without solver error; null where it does not iterate.
  const Trajectory* converged_run(const Dial& dial) {
    if (!trial.split) return nullptr;
    const std::optional<Scene> scene = converged(trial.scene, dial);
    if (!scene) return nullptr;
    const auto [entry, is_new] =
        converged_runs.try_emplace({scene->simulation.method, *dial.substeps});
    if (is_new) entry->second = run(simulator_of(*scene), trial.frames, {0, 60}).trajectory;
    const bool whole = entry->second.size() == reference.trajectory.size();
    return whole ? &entry->second : nullptr;
  }
};

/// The smallest error of a run that the reference can resolve.
double min_error(const Reference& reference) {
  double own = 0;
  for (std::size_t i = 0; i < reference.horizon; ++i) own = std::max(own, reference.own_error(i));
  return own / trusted;
}

void add_reference(const Judge& judge, Tables& tables) {
  const Trial& trial = judge.trial;
  const Reference& reference = judge.reference;
  double uncertainty = 0, growth = 0;
  for (std::size_t i = 0; i < reference.uncertainty.size(); ++i) {
    uncertainty = std::max(uncertainty, reference.uncertainty[i]);
    growth = std::max(growth, reference.growth[i]);
  }
  const double seconds = reference.trajectory.back().time;
  const double horizon =
      reference.horizon > 0 ? reference.trajectory[reference.horizon - 1].time : 0;
  const double own_error = trusted * min_error(reference);  // up to the horizon
  tables.references.add({trial.name, trial.scene.cloth.columns, trial.scene.cloth.rows,
                         trial.compared == Compared::rest_shape ? "rest_shape" : "all_frames",
                         seconds, reference.substeps, trial.smooth ? 1 : 0, reference.order,
                         reference.cross_check, uncertainty, growth, horizon, own_error});
  std::printf(
      "%-16s reference: order %.3f, its own error %.1e, distance to rk4 %.1e, a nudge grows"
      " %.3g times, compared up to %.3g s\n",
      trial.name.c_str(), reference.order, uncertainty, reference.cross_check, growth, horizon);
  std::fflush(stdout);
}

void add_run(Judge& judge, const std::string& name, const Dial& dial, const Run& run,
             const Trajectory* solved, Tables& tables) {
  const Score s = score(run, judge.reference, judge.trial);
  const bool failed = run.outcome == Outcome::done && s.position >= lost;
  double solver_error = Score::none, scheme_error = Score::none;
  if (solved != nullptr && run.outcome == Outcome::done) {
    const bool rest = judge.trial.compared == Compared::rest_shape;
    const std::size_t frames = rest ? 1 : run.trajectory.size();
    const double size = size_of(judge.trial.scene);
    solver_error = rms_distance(run.trajectory, *solved, frames) / size;
    scheme_error = rms_distance(*solved, judge.reference.trajectory, frames) / size;
  }
  tables.runs.add({judge.trial.name,
                   judge.trial.scene.cloth.columns,
                   name,
                   run.method,
                   run.substeps,
                   dial.iterations.value_or(1),
                   failed ? name_of(Outcome::failed) : name_of(run.outcome),
                   run.cost,
                   run.repeats,
                   s.position,
                   s.position_max,
                   s.velocity,
                   s.energy,
                   s.momentum,
                   s.centre,
                   s.worst_stretch,
                   s.p99_stretch,
                   solver_error,
                   scheme_error,
                   s.horizon,
                   run.predicted_error});
  if (failed || run.outcome != Outcome::done) return;
  const double least = min_error(judge.reference);
  const Contender contender{run.method, run.cost, std::isnan(s.position) ? least : s.position};
  if (name == "auto") {
    judge.chosen = contender;
    judge.predicted_error = run.predicted_error;
  } else if (wanted(method_names(), name)) {
    judge.others.push_back(contender);
  }
}

/// The choice of `auto`, its predicted error, and the best method that it did not choose.
void add_choice(const Judge& judge, Tables& tables) {
  if (!judge.chosen) return;
  const Contender& chosen = *judge.chosen;
  const Contender best =
      best_passed_over(chosen, judge.others).value_or(Contender{"", Score::none, Score::none});
  tables.choices.add({judge.trial.name, chosen.method, chosen.cost, chosen.error,
                      judge.predicted_error, best.method, best.cost, best.error});
  std::printf("%-16s auto: %s, error %.1e, foretold %.1e; passed over at its cost: %s %.1e\n",
              judge.trial.name.c_str(), chosen.method.c_str(), chosen.error, judge.predicted_error,
              best.method.empty() ? "none" : best.method.c_str(), best.error);
  std::fflush(stdout);
}

}  // namespace

std::vector<Job> methods_jobs(const Options& options) {
  auto tables = std::make_shared<Tables>();
  std::vector<Job> jobs;
  for (const Trial& trial : trials(options.quick)) {
    if (!wanted(options.scenes, trial.name)) continue;
    auto judge = std::make_shared<Judge>(trial);
    jobs.push_back([=] {
      judge->reference = make_reference(judge->trial);
      add_reference(*judge, *tables);
    });
    for (const Dial& dial : dials(trial, options.quick)) {
      if (!wanted(options.methods, dial.name())) continue;
      jobs.push_back([=] {
        const Run result =
            run(simulator_of(at(judge->trial.scene, dial)), judge->trial.frames, run_budget);
        add_run(*judge, dial.name(), dial, result, judge->converged_run(dial), *tables);
      });
    }
    for (const Peer& peer : peers(trial, options.quick)) {
      if (!wanted(options.methods, peer.name)) continue;
      jobs.push_back([=] {
        const Run result = run(peer.make, judge->trial.frames, run_budget);
        add_run(*judge, peer.name, peer.dial, result, nullptr, *tables);
      });
    }
    // After each scene, so that an interrupted run leaves results.
    jobs.push_back([=] {
      add_choice(*judge, *tables);
      judge->reference = {};
      judge->converged_runs.clear();
      tables->runs.write(options.output / "methods.csv");
      tables->references.write(options.output / "references.csv");
      tables->choices.write(options.output / "choices.csv");
    });
  }
  return jobs;
}

}  // namespace clothsim::work_precision
