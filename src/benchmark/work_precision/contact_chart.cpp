// Cost of self contact by points and by surfaces, and the crossings that each leaves.

#include <algorithm>
#include <memory>

#include "../cpu_time.h"
#include "chart.h"
#include "clothsim/dynamics/energy.h"
#include "clothsim/geometry/intersections.h"
#include "clothsim/simulation/simulator.h"
#include "scenes.h"
#include "table.h"

namespace clothsim::work_precision {
namespace {

/// A pile of the same cloth, with another material or other points.
struct Pile {
  const char* name;
  int side;              // points along either side
  double ks = 5000;      // [N/m]
  double density = 150;  // [kg/m^2]
  double thickness = 0;  // [m]; 0: of the shipped scene, reduced with the distance of the points
};

/// By number of points, at the same frame, as the first folds touch; and cases beyond contact by
/// points, until the cloth lies still.
struct ContactSeries {
  const char* name;
  int frames;
  int measured_from;  // first frame whose cost counts
  std::vector<Pile> piles;
};

std::vector<ContactSeries> contact_series(bool quick) {
  if (quick) return {{"points", 45, 27, {{"shipped", 15}}}};
  return {
      {"points", 54, 36, {{"shipped", 25}, {"shipped", 50}, {"shipped", 100}, {"shipped", 200}}},
      {"materials",
       450,
       0,
       {{"shipped", 50},
        {"ks 50", 50, 50},
        {"ks 100000", 50, 1e5},
        {"density 10000", 50, 5000, 1e4},
        {"1 mm thick", 50, 5000, 150, 0.001}}}};
}

Scene scene_of(const Pile& pile, SelfCollision kind) {
  Scene scene = fold(pile.side);
  scene.cloth.material.ks = pile.ks;
  scene.cloth.material.density = pile.density;
  if (pile.thickness > 0) scene.cloth.thickness = pile.thickness;
  scene.cloth.self_collision = kind;
  return scene;
}

}  // namespace

std::vector<Job> contact_jobs(const Options& options) {
  auto table = std::make_shared<Table>(std::vector<std::string>{
      "series", "pile", "side", "contact", "cost_ms_per_s", "crossings", "rest_speed"});
  std::vector<Job> jobs;
  for (const ContactSeries& s : contact_series(options.quick)) {
    for (const Pile& pile : s.piles) {
      for (const auto& [contact, kind] : {std::pair{"points", SelfCollision::points},
                                          std::pair{"surface", SelfCollision::surface}}) {
        jobs.push_back([=, contact = contact, kind = kind] {
          const Scene scene = scene_of(pile, kind);
          Simulator simulator(scene);
          double cost = 0;  // [s]
          int crossings = 0;
          for (int frame = 0; frame < s.frames; ++frame) {
            const double start = cpu_seconds();
            simulator.step();
            if (frame >= s.measured_from) cost += cpu_seconds() - start;
            const int now = count_intersections(simulator.cloth(), simulator.state().positions);
            crossings = std::max(crossings, now);
          }
          const double simulated = (s.frames - s.measured_from) * simulator.frame_duration();
          table->add({s.name, pile.name, pile.side, contact, 1e3 * cost / simulated, crossings,
                      rms_velocity(simulator.state())});
        });
      }
    }
  }
  jobs.push_back([=] { table->write(options.output / "contact.csv"); });
  return jobs;
}

}  // namespace clothsim::work_precision
