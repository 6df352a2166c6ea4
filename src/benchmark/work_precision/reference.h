#pragma once

#include <vector>

#include "run.h"
#include "scenes.h"

namespace clothsim::work_precision {

/// The reference for the runs of a trial. Lengths are relative to the cloth's size.
struct Reference {
  Trajectory trajectory;
  std::vector<double> uncertainty;  // RMS position error of the reference itself, by frame
  std::vector<double> growth;       // of a twin's distance, by frame
  std::size_t horizon = 0;          // frames in which points are compared
  double order = 0;                 // observed; 2 where the motion is smooth
  double cross_check = 0;           // RMS distance to rk4, over all points and frames
  int substeps = 0;                 // of its finest run

  double own_error(std::size_t frame) const { return growth[frame] * uncertainty[frame]; }
};

/// Largest share of the reference's own error in a run's error.
inline constexpr double trusted = 0.1;

/// Verlet at h, h/2 and h/4. The result is Richardson's (4 x_{h/4} - x_{h/2}) / 3 in a smooth
/// trial, else the finest run. Uncertainty is the larger of the distance to rk4 and the change by
/// the last halving (after Richardson, which is of order 4, a fifteenth of that). The twin starts
/// from a cloth perturbed by 1e-10 of its size. The horizon is where the twin's growth times the
/// uncertainty reaches a tenth of the trial's `charted_error`; it is the same for all runs, so that
/// their errors compare. Shapes at rest do not diverge: there the twin's distance counts as
/// uncertainty, and growth is 1. Throws Diverged.
Reference make_reference(const Trial&);

/// The same from runs close to Verlet's limit, without rk4 and twin: for large and short trials,
/// which are smooth.
Reference make_cheap_reference(const Trial&);

/// The same scene, larger by 1e-10 and pulled as much sideways: in chaotic motion its points
/// diverge from the original's.
Scene twin_of(Scene);

/// Larger side of the cloth [m].
double size_of(const Scene&);

/// RMS distance between the points of two states [m].
double rms_distance(const Points& a, const Points& b);

/// RMS distance over points and frames [m], of the last `frames` frames.
double rms_distance(const Trajectory& a, const Trajectory& b, std::size_t frames);

}  // namespace clothsim::work_precision
