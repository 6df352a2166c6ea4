#include "classic.h"

#include <cmath>

#include "clothsim/dynamics/springs.h"
#include "clothsim/model/errors.h"
#include "clothsim/model/grid.h"

namespace clothsim::work_precision {
namespace {

class Classic : public Stepper {
 public:
  Classic(const Scene& scene, int substeps, int passes, bool follow)
      : cloth_(make_grid(scene.cloth)),
        state_(start_state(scene.cloth, cloth_, scene.simulation.seed)),
        gravity_(scene.simulation.gravity),
        frame_(1 / scene.simulation.frames_per_second),
        substeps_(substeps),
        passes_(passes),
        follow_(follow) {
    const State& state = state_;
    for_each_spring(cloth_, [&](const SpringRun& run, int a, int b) {
      springs_.push_back({a, b, run.rest_length, run.stiffness});
    });
    for (int i = 0; i < cloth_.num_points(); ++i) {
      points_.push_back({state.positions.row(i).transpose(), Vector3::Zero(), Vector3::Zero(),
                         Vector3::Zero(), cloth_.mass[i], cloth_.inv_mass[i]});
    }
  }

  StepReport step() override {
    for (int k = 0; k < substeps_; ++k) substep(frame_ / substeps_);
    for (int i = 0; i < cloth_.num_points(); ++i) {
      state_.positions.row(i) = points_[static_cast<std::size_t>(i)].x.transpose();
      state_.velocities.row(i) = points_[static_cast<std::size_t>(i)].v.transpose();
    }
    state_.time += frame_;
    if (!state_.positions.allFinite()) throw Diverged("the classic configuration diverged");
    StepReport report;
    report.method = "classic";
    report.substeps = substeps_;
    report.sweeps = passes_ * substeps_;
    return report;
  }

  const State& state() const override { return state_; }

 private:
  struct Point {
    Vector3 x, v, force;
    Vector3 start;  // at the start of the substep
    double mass, inv_mass;
  };
  struct Spring {
    int a, b;
    double rest_length, stiffness;
  };

  Point& point(int i) { return points_[static_cast<std::size_t>(i)]; }

  void substep(double h) {
    // Forces, spring by spring.
    for (Point& p : points_) p.force = p.mass * gravity_;
    for (const Spring& s : springs_) {
      Point& a = point(s.a);
      Point& b = point(s.b);
      const Vector3 d = b.x - a.x;
      const double length = d.norm();
      const Vector3 pull = s.stiffness * (length - s.rest_length) / length * d;
      a.force += pull;
      b.force -= pull;
    }

    // Velocities, then positions.
    const double kept = std::exp(-cloth_.damping * h);
    for (Point& p : points_) {
      if (p.inv_mass == 0) continue;
      p.start = p.x;
      p.v = kept * p.v + h * p.inv_mass * p.force;
      p.x += h * p.v;
    }

    // The strain limit, spring by spring.
    if (!cloth_.strain_limit) return;
    for (int pass = 0; pass < passes_; ++pass) {
      for (const Spring& s : springs_) shorten(s);
    }
    if (!follow_) return;
    for (Point& p : points_) {
      if (p.inv_mass > 0) p.v = (p.x - p.start) / h;
    }
  }

  void shorten(const Spring& s) {
    Point& a = point(s.a);
    Point& b = point(s.b);
    const Vector3 d = b.x - a.x;
    const double length = d.norm();
    const double longest = (1 + *cloth_.strain_limit) * s.rest_length;
    if (length <= longest || a.inv_mass + b.inv_mass == 0) return;
    const Vector3 move = (length - longest) / length / (a.inv_mass + b.inv_mass) * d;
    a.x += a.inv_mass * move;
    b.x -= b.inv_mass * move;
  }

  Cloth cloth_;
  State state_;
  Vector3 gravity_;
  double frame_;  // [s]
  int substeps_;
  int passes_;
  bool follow_;
  std::vector<Point> points_;
  std::vector<Spring> springs_;
};

}  // namespace

StepperMaker classic(const Scene& scene, int substeps, int passes, bool follow) {
  return [=] { return std::make_unique<Classic>(scene, substeps, passes, follow); };
}

}  // namespace clothsim::work_precision
