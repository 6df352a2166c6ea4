// Bullet's soft bodies, on the scenes without contact and strain limit: neither has a strain limit.

#include "bullet_cloth.h"
#include "peers.h"

namespace clothsim::work_precision {

std::vector<Peer> peers(const Trial& trial, bool quick) {
  std::vector<Peer> list;
  if (!trial.smooth) return list;
  const auto add = [&](const char* name, BulletWorld world, int substeps, int iterations,
                       bool matched) {
    const Dial dial{name, substeps, iterations};
    list.push_back({name, dial, bullet(trial.scene, world, substeps, iterations, matched)});
  };

  // Substeps with one pass, then passes at Bullet's usual one to four substeps a frame.
  struct Setting {
    int substeps;
    int iterations;
  };
  const std::vector<Setting> settings =
      quick ? std::vector<Setting>{{4, 4}}
            : std::vector<Setting>{{1, 1},  {4, 1},  {16, 1}, {64, 1}, {256, 1},
                                   {1, 10}, {1, 50}, {4, 10}, {4, 50}, {16, 10}};
  for (const Setting& s : settings) {
    add("bullet_matched", BulletWorld::positions, s.substeps, s.iterations, true);
    add("bullet", BulletWorld::positions, s.substeps, s.iterations, false);
  }
  for (const int substeps : quick ? std::vector{4} : std::vector{1, 2, 4, 8, 16, 32}) {
    add("bullet_deformable", BulletWorld::springs, substeps, 1, false);
  }
  return list;
}

}  // namespace clothsim::work_precision
