#include "run.h"

#include <algorithm>

#include "../cpu_time.h"
#include "clothsim/model/errors.h"

namespace clothsim::work_precision {
namespace {

constexpr int max_repeats = 3;

class SimulatorStepper : public Stepper {
 public:
  explicit SimulatorStepper(const Scene& scene) : simulator_(scene) {}
  StepReport step() override { return simulator_.step(); }
  const State& state() const override { return simulator_.state(); }

 private:
  Simulator simulator_;
};

/// One run; adds its time to `spent` [s].
Run run_once(Stepper& stepper, int frames, double stop, double& spent) {
  Run run;
  double seconds = 0;
  double sweeps = 0;
  long long substeps = 0;
  const double start_time = stepper.state().time;
  try {
    while (static_cast<int>(run.trajectory.size()) < frames) {
      if (seconds > stop) {
        run.outcome = Outcome::stopped;
        break;
      }
      const double start = process_cpu_seconds();
      const StepReport report = stepper.step();
      seconds += process_cpu_seconds() - start;
      run.trajectory.push_back(stepper.state());
      run.method = report.method;
      run.substeps = report.substeps;
      run.predicted_error = report.predicted_error.value_or(run.predicted_error);
      sweeps += report.sweeps;
      substeps += report.substeps;
    }
  } catch (const Diverged&) {
    run.outcome = Outcome::failed;
  }
  const double simulated = run.trajectory.empty() ? 0 : stepper.state().time - start_time;
  run.cost = simulated > 0 ? 1e3 * seconds / simulated : std::numeric_limits<double>::quiet_NaN();
  run.sweeps = substeps > 0 ? sweeps / static_cast<double>(substeps) : 0;
  spent += seconds;
  return run;
}

}  // namespace

StepperMaker simulator_of(const Scene& scene) {
  return [scene] { return std::make_unique<SimulatorStepper>(scene); };
}

const char* name_of(Outcome outcome) {
  switch (outcome) {
    case Outcome::done:
      return "done";
    case Outcome::failed:
      return "failed";
    case Outcome::stopped:
      return "stopped";
  }
  return "";
}

Run run(const StepperMaker& make, int frames, const Budget& budget) {
  double spent = 0;
  Run run = run_once(*make(), frames, budget.stop, spent);
  run.repeats = 1;
  while (run.outcome == Outcome::done && run.repeats < max_repeats && spent < budget.repeat) {
    run.cost = std::min(run.cost, run_once(*make(), frames, budget.stop, spent).cost);
    ++run.repeats;
  }
  return run;
}

}  // namespace clothsim::work_precision
