// The distribution of the springs' stretch, by method: it can be compared even in chaotic motion,
// where points cannot.

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "chart.h"
#include "clothsim/dynamics/springs.h"
#include "clothsim/model/grid.h"
#include "dials.h"
#include "reference.h"
#include "table.h"

namespace clothsim::work_precision {
namespace {

struct StretchSeries {
  const char* name;
  Scene scene;
  int frames;
  int counted_from;  // first frame that counts
};

std::vector<StretchSeries> stretch_series(bool quick) {
  if (quick) return {{"sphere_drop", sphere_drop(8), 54, 45}};
  const int side = 25;
  return {{"sphere_drop", sphere_drop(side), 270, 90}, {"fold", fold(side), 270, 90}};
}

/// Shares of all springs in all frames by stretch l / L0 - 1; values outside count in the outermost
/// bin.
class Histogram {
 public:
  static constexpr int bins = 150;
  static constexpr double lowest = -0.5, highest = 0.25, width = (highest - lowest) / bins;

  void add(const Cloth& cloth, const Points& x) {
    for_each_spring(cloth, [&](const SpringRun& spring, int a, int b) {
      const double stretch = (x.row(b) - x.row(a)).norm() / spring.rest_length - 1;
      const double bin = std::floor((stretch - lowest) / width);
      ++counts_[static_cast<std::size_t>(std::clamp(bin, 0.0, bins - 1.0))];
      ++total_;
    });
  }
  double share(int bin) const { return counts_[static_cast<std::size_t>(bin)] / total_; }

 private:
  std::array<double, bins> counts_{};
  double total_ = 0;
};

/// Every method with its usual substeps; Verlet with four times as many, and its twin, whose
/// difference from it is chance.
std::vector<std::pair<std::string, Scene>> contenders(const Scene& scene, int usual) {
  std::vector<std::pair<std::string, Scene>> list;
  const Scene fine = at(scene, {VelocityVerlet::name, 4 * usual});
  list.emplace_back("reference", fine);
  list.emplace_back("twin", twin_of(fine));
  for (const std::string& method : method_names()) {
    list.emplace_back(method, at(scene, {method, std::nullopt}));
  }
  return list;
}

}  // namespace

std::vector<Job> stretch_jobs(const Options& options) {
  auto table = std::make_shared<Table>(std::vector<std::string>{
      "scene", "columns", "from_s", "to_s", "method", "substeps", "status", "stretch", "share"});
  std::vector<Job> jobs;
  for (const StretchSeries& s : stretch_series(options.quick)) {
    const int usual = run(simulator_of(at(s.scene, {VelocityVerlet::name, {}})), 1).substeps;
    for (const auto& [method, scene] : contenders(s.scene, usual)) {
      if (!wanted(options.methods, method)) continue;
      jobs.push_back([=, method = method, scene = scene] {
        const Run result = run(simulator_of(scene), s.frames, {0, 120});
        const Cloth cloth = make_grid(scene.cloth);
        const double fps = scene.simulation.frames_per_second;
        Histogram histogram;
        for (std::size_t i = static_cast<std::size_t>(s.counted_from); i < result.trajectory.size();
             ++i) {
          histogram.add(cloth, result.trajectory[i].positions);
        }
        for (int bin = 0; bin < Histogram::bins; ++bin) {
          table->add({s.name, scene.cloth.columns, s.counted_from / fps, s.frames / fps, method,
                      result.substeps, name_of(result.outcome),
                      Histogram::lowest + (bin + 0.5) * Histogram::width, histogram.share(bin)});
        }
      });
    }
  }
  jobs.push_back([=] { table->write(options.output / "stretch.csv"); });
  return jobs;
}

}  // namespace clothsim::work_precision
