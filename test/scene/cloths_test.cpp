// Several cloths in whole scenes.

#include <array>
#include <cmath>

#include "clothsim/dynamics/springs.h"
#include "clothsim/dynamics/stretch.h"
#include "clothsim/geometry/intersections.h"
#include "clothsim/model/join_cloths.h"
#include "clothsim/run/motion_player.h"
#include "clothsim/scene/scene_yaml.h"
#include "verification/mesh_fabric_testing.h"

namespace clothsim::cloths_test {
namespace {

using namespace test;

Points part_of(const Simulator& simulator, std::size_t i) {
  const ClothPart& part = simulator.scene().cloth.parts[i];
  return simulator.state().positions.middleRows(part.first_point, part.num_points());
}

double part_mass(const Simulator& simulator, std::size_t i) {
  const ClothPart& part = simulator.scene().cloth.parts[i];
  return simulator.cloth().mass.segment(part.first_point, part.num_points()).sum();
}

/// Two sheets of 0.2 m on a floor, one on the other or beside it, as a stack in a drawer.
YAML::Node stack(double shift) {
  YAML::Node root = YAML::Load(R"(
colliders: [{name: floor, shape: plane, friction: 0.5}]
simulation: {method: xpbd, substeps: 8, frames_per_second: 60}
)");
  for (int i = 0; i < 2; ++i) {
    YAML::Node cloth =
        YAML::Load("{fabric: linen, width: 0.2, height: 0.2, columns: 11, rows: 11, damping: 1}");
    cloth["name"] = i == 0 ? "lower" : "upper";
    cloth["origin"] = std::vector<double>{i * shift, 0, 0.002 + 0.002 * i};
    root["cloths"].push_back(cloth);
  }
  return root;
}

TEST(Cloths, AHandTakesTheUpperOneOfAStack) {
  YAML::Node root = stack(0.01);
  root["motions"] = YAML::Load(R"(
- {time: 0.3, frame: hand, position: [0.01, 0, 0.001]}
- {time: 0.3, attach: hand, cloth: upper, points: [[0, 0], [1, 0], [0, 1]]}
- {time: 0.8, frame: hand, position: [0.05, 0.05, 0.2]}
- {time: 1.5, frame: hand, position: [0.4, 0, 0.3]}
- {time: 2.0, frame: hand, position: [0.4, 0, 0.15]}
- {time: 2.1, detach: hand}
)");
  Simulator simulator(read_scene(root));
  MotionPlayer player(simulator, ".");
  const Points before = part_of(simulator, 0);
  int crossings = 0;
  for (int frame = 0; frame < 240; ++frame) {
    player.play(simulator);
    simulator.step();
    if (frame % 10 == 0) {
      crossings += count_intersections(simulator.cloth(), simulator.state().positions);
    }
  }
  EXPECT_EQ(crossings, 0);
  const Points lower = part_of(simulator, 0), upper = part_of(simulator, 1);
  EXPECT_LT((lower - before).leftCols(2).rowwise().norm().maxCoeff(), 2e-3);
  EXPECT_GT(upper.col(0).minCoeff(), 0.25);
  EXPECT_LT(rms_velocity(simulator.state()), 2e-3);
}

TEST(Cloths, AClothThatTouchesNothingMovesAsAlone) {
  // While one of another fabric lies on the floor; once it touches itself, both share a number of
  // passes.
  for (const char* simulation : {"{method: xpbd, substeps: 8}", "{method: verlet, substeps: 60}"}) {
    YAML::Node both = stack(1.0);
    both["simulation"] = YAML::Load(simulation);
    both["cloths"][0]["pinned"] = YAML::Load("[[0, 0]]");
    both["cloths"][0]["origin"] = std::vector<double>{0, 0, 0.5};
    both["cloths"][1]["fabric"] = "cotton_towel";
    YAML::Node alone = YAML::Clone(both);
    alone["cloths"].remove(1);
    Simulator of_both(read_scene(both)), of_one(read_scene(alone));
    for (int frame = 0; frame < 18; ++frame) {
      EXPECT_EQ(of_one.step().contacts, 0);
      of_both.step();
    }
    const Points one = of_one.state().positions;
    EXPECT_LT(one.col(2).minCoeff(), 0.4);  // it has swung
    EXPECT_EQ(part_of(of_both, 0), one);
    EXPECT_EQ(of_both.holders().at(0).force, of_one.holders().at(0).force);
    EXPECT_GT(of_one.holders().at(0).force, 0);
  }
}

/// Two sheets that hang by a corner each in a wind, far apart, with their own drag and damping.
YAML::Node in_the_wind(const std::string& simulation) {
  YAML::Node root = stack(1.0);
  root.remove("colliders");
  root["simulation"] = YAML::Load(simulation);
  root["simulation"]["wind"] = std::vector<double>{2, 1, 0};
  for (int i = 0; i < 2; ++i) root["cloths"][i]["pinned"] = YAML::Load("[[0, 0]]");
  root["cloths"][0]["damping"] = 4;
  root["cloths"][0]["drag"] = std::vector<double>{2, 0.5};
  root["cloths"][1]["damping"] = 0.2;
  return root;
}

TEST(Cloths, HaveTheirOwnDragAndDampingWithAllMethods) {
  // Solvers share tolerances, and Verlet's displacements have one factor for all cloths: their
  // difference is g h^3 / 12 times that of the dampings a substep.
  for (const char* simulation :
       {"{method: verlet, substeps: 60}", "{method: symplectic_euler, substeps: 60}",
        "{method: rk4, substeps: 60}", "{method: xpbd, substeps: 8}",
        "{method: implicit_euler, substeps: 4, method_parameters: {tolerance: 1.0e-9}}",
        "{method: bdf2, substeps: 4, method_parameters: {tolerance: 1.0e-9}}"}) {
    const YAML::Node both = in_the_wind(simulation);
    Simulator of_both(read_scene(both));
    std::vector<Simulator> alone;
    for (int i = 0; i < 2; ++i) {
      YAML::Node root = YAML::Clone(both);
      root["cloths"].remove(1 - i);
      alone.emplace_back(read_scene(root));
    }
    for (int frame = 0; frame < 20; ++frame) {
      of_both.step();
      for (Simulator& one : alone) one.step();
    }
    for (std::size_t i = 0; i < 2; ++i) {
      const Points& one = alone[i].state().positions;
      EXPECT_LT((part_of(of_both, i) - one).cwiseAbs().maxCoeff(), 2e-6) << simulation << i;
      EXPECT_LT(one.col(2).minCoeff(), -0.1) << "it has swung";
      EXPECT_NEAR(of_both.holders().at(i).force, alone[i].holders().at(0).force,
                  1e-3 * alone[i].holders().at(0).force);
    }
  }
}

TEST(Cloths, HaveTheirOwnStrainLimits) {
  // Three soft sheets that hang by two corners: limits of 3 and 20 percent, and none.
  YAML::Node root = stack(1.0);
  root["simulation"] = YAML::Load("{method: verlet, substeps: 40}");
  root["cloths"].push_back(YAML::Clone(root["cloths"][1]));
  root["cloths"][2]["name"] = "third";
  root["cloths"][2]["origin"] = std::vector<double>{2, 0, 0.5};
  for (int i = 0; i < 3; ++i) {
    root["cloths"][i]["stretch_stiffness"] = std::vector<double>{2, 2};
    root["cloths"][i]["shear_stiffness"] = 1;
    root["cloths"][i]["damping"] = 5 - i;
    root["cloths"][i]["pinned"] = YAML::Load("[[0, 0], [10, 0]]");
    root["cloths"][i]["origin"] = std::vector<double>{1.0 * i, 0, 0.5};
  }
  root["cloths"][0]["strain_limit"] = 0.03;
  root["cloths"][1]["strain_limit"] = 0.2;
  Simulator simulator(read_scene(root));
  const auto stretch_of = [&](int i) {
    double worst = 0;
    for_each_spring(simulator.cloth(), [&](const SpringRun& run, int a, int b) {
      if (simulator.cloth().cloth_of(a) != static_cast<std::size_t>(i)) return;
      const Points& x = simulator.state().positions;
      worst = std::max(worst, (x.row(b) - x.row(a)).norm() / run.rest_length - 1);
    });
    return worst;
  };
  StepReport report;
  for (int frame = 0; frame < 120; ++frame) report = simulator.step();
  EXPECT_LT(stretch_of(0), 0.035);
  EXPECT_GT(stretch_of(0), 0.029);
  EXPECT_LT(stretch_of(1), 0.205);
  EXPECT_GT(stretch_of(1), 0.19);
  EXPECT_GT(stretch_of(2), 0.3);
  EXPECT_LT(report.violation, 0.005);
  EXPECT_EQ(report.worst_stretch, stretch_of(2));
  EXPECT_FALSE(report.reasons.has(Reason::passes_unconverged));

  // Limits that change: the first loses its own, the third gets one.
  LiveSpec live = live_values(simulator.scene());
  live.cloths[0].material.strain_limit.reset();
  live.cloths[2].material.strain_limit = 0.1;
  simulator.set(live);
  for (int frame = 0; frame < 240; ++frame) report = simulator.step();
  EXPECT_GT(stretch_of(0), 0.3);
  EXPECT_LT(stretch_of(1), 0.205);
  EXPECT_LT(stretch_of(2), 0.105);
  EXPECT_LT(report.violation, 0.005);
}

TEST(Cloths, OnEachOtherPressOnTheFloorWithTheirWeight) {
  // To half of the difference of their dampings times a substep: see docs/limits.md.
  for (const char* simulation : {"{method: verlet}", "{method: xpbd, substeps: 8}"}) {
    YAML::Node root = stack(0.01);
    root["simulation"] = YAML::Load(simulation);
    root["cloths"][0]["damping"] = 30;
    root["cloths"][1]["damping"] = 2;
    Simulator simulator(read_scene(root));
    for (int frame = 0; frame < 120; ++frame) simulator.step();
    simulator.measure_wrenches(true);
    double force = 0;
    int substeps = 0;
    for (int frame = 0; frame < 30; ++frame) {
      substeps = simulator.step().substeps;
      force += simulator.collider_wrenches()[0].force.z() / 30;
    }
    const double differs = (30 - 2) / (60.0 * substeps) / 2;
    EXPECT_NEAR(force / (9.8 * simulator.cloth().mass.sum()), -1, differs) << simulation;
    EXPECT_LT(rms_velocity(simulator.state()), 1e-3);
  }
}

TEST(Cloths, CarryEachOther) {
  // A sheet hung by its corners holds another that falls on it.
  YAML::Node root = stack(0);
  root["colliders"] = YAML::Node();
  root.remove("colliders");
  root["cloths"][0]["pinned"] = YAML::Load("[[0, 0], [10, 0], [0, 10], [10, 10]]");
  root["cloths"][0]["origin"] = std::vector<double>{0, 0, 0.5};
  root["cloths"][1]["origin"] = std::vector<double>{0.03, 0.02, 0.55};
  root["cloths"][1]["width"] = root["cloths"][1]["height"] = 0.1;
  root["cloths"][1]["columns"] = root["cloths"][1]["rows"] = 6;
  YAML::Node alone = YAML::Clone(root);
  alone["cloths"].remove(1);
  Simulator simulator(read_scene(root)), without(read_scene(alone));
  const auto pull = [](Simulator& of) {  // mean over the pins and the last second [N]
    double sum = 0;
    for (int frame = 0; frame < 240; ++frame) {
      of.step();
      if (frame < 180) continue;
      for (const HolderReport& pin : of.holders()) sum += pin.force / 60;
    }
    return sum;
  };
  const double weight = 9.8 * part_mass(simulator, 1);
  EXPECT_GT(pull(simulator), pull(without) + weight);
  EXPECT_EQ(count_intersections(simulator.cloth(), simulator.state().positions), 0);
  EXPECT_GT(part_of(simulator, 1).col(2).minCoeff(), 0.4);
  EXPECT_LT(part_of(simulator, 1).col(2).maxCoeff(), 0.5);
}

TEST(Cloths, KeepTheirDistanceHoweverNearTheyStart) {
  for (const double gap : {0.01, 0.002, 0.0006, 0.0001}) {
    YAML::Node root = stack(0);
    root["cloths"][1]["origin"] = std::vector<double>{0, 0, 0.002 + gap};
    Simulator simulator(read_scene(root));
    for (int frame = 0; frame < 120; ++frame) simulator.step();
    const Points lower = part_of(simulator, 0), upper = part_of(simulator, 1);
    const double apart = upper.col(2).mean() - lower.col(2).mean();
    EXPECT_NEAR(apart, 2 * simulator.cloth().thickness, 0.02 * apart) << gap;
  }
}

double height_of(const Simulator& simulator, std::size_t i) {
  return part_of(simulator, i).col(2).mean();
}

TEST(Cloths, KeepTheSumOfTheirThicknesses) {
  for (const auto& thickness : {std::array{2e-3, 3e-4, 1e-3}, {3e-4, 1e-3, 2e-3}}) {
    YAML::Node root = stack(0);
    root["cloths"].push_back(YAML::Clone(root["cloths"][1]));
    root["cloths"][2]["name"] = "third";
    for (std::size_t i = 0; i < 3; ++i) {
      root["cloths"][i]["thickness"] = thickness[i];
      root["cloths"][i]["origin"] = std::vector<double>{0, 0, 0.003 + 0.005 * double(i)};
    }
    Simulator simulator(read_scene(root));
    for (int frame = 0; frame < 120; ++frame) simulator.step();
    double expected = 0, last = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      expected += last + thickness[i];
      last = thickness[i];
      EXPECT_NEAR(height_of(simulator, i), expected, 0.02 * expected) << i;
    }
    EXPECT_EQ(count_intersections(simulator.cloth(), simulator.state().positions), 0);
  }
}

TEST(Cloths, KeepTheirOwnThicknessOffColliders) {
  for (const char* shape :
       {"{shape: plane}", "{shape: box, size: [3, 3, 0.1], center: [0, 0, -0.05]}",
        "{shape: cylinder, radius: 2, length: 0.1, center: [0, 0, -0.05]}"}) {
    for (const char* method : {"xpbd", "verlet"}) {
      YAML::Node root = stack(0.3);
      root["colliders"][0] = YAML::Load(shape);
      root["simulation"]["method"] = method;
      if (std::string(method) == "verlet") root["simulation"].remove("substeps");
      const std::array<double, 2> thickness{3e-4, 4e-3};
      for (std::size_t i = 0; i < 2; ++i) {
        root["cloths"][i]["thickness"] = thickness[i];
        root["cloths"][i]["origin"] = std::vector<double>{0.3 * double(i), 0, 0.006};
      }
      Simulator simulator(read_scene(root));
      for (int frame = 0; frame < 60; ++frame) simulator.step();
      for (std::size_t i = 0; i < 2; ++i) {
        EXPECT_NEAR(height_of(simulator, i), thickness[i], 1e-5) << shape << " " << method;
      }
      EXPECT_LT(rms_velocity(simulator.state()), 2e-3);
    }
  }
}

TEST(Cloths, AreStoppedByCollidersAlsoAfterALiveThickness) {
  for (const char* simulation : {"{method: xpbd, substeps: 10}", "{method: verlet}"}) {
    YAML::Node root = stack(1.0);
    root["simulation"] = YAML::Load(simulation);
    root["cloths"][0]["thickness"] = 1e-3;
    root["cloths"][1]["thickness"] = 0.03;
    root["cloths"][0]["origin"] = std::vector<double>{0, 0, 0.05};
    root["cloths"][1]["origin"] = std::vector<double>{1, 0, 0.035};
    Simulator simulator(read_scene(root));
    for (int frame = 0; frame < 60; ++frame) {
      if (frame == 4) {
        LiveSpec live = live_values(simulator.scene());
        live.cloths[1].thickness = 1e-3;
        simulator.set(live);
      }
      simulator.step();
      EXPECT_GT(part_of(simulator, 0).col(2).minCoeff(), 9e-4) << simulation << " " << frame;
    }
  }
}

/// A sheet of linen, and beside it, far away, one of that thickness, if any [m].
Scene beside(double thickness, const char* collider, const char* simulation) {
  YAML::Node root;
  root["colliders"].push_back(YAML::Load(collider));
  root["simulation"] = YAML::Load(simulation);
  for (int i = 0; i < (thickness > 0 ? 2 : 1); ++i) {
    YAML::Node cloth = YAML::Load(
        "{fabric: linen, width: 0.2, height: 0.2, columns: 11, rows: 11, damping: 2, "
        "self_collision: false}");
    cloth["name"] = i == 0 ? "thin" : "thick";
    cloth["thickness"] = i == 0 ? 5e-4 : thickness;
    cloth["origin"] = std::vector<double>{3.0 * i, 0, i == 0 ? 0.1 : 30};
    root["cloths"].push_back(cloth);
  }
  return read_scene(root);
}

TEST(Cloths, LeaveAColliderTurnedOnInsideAsTheyWouldAlone) {
  // Between the points of the thin one, 2 to 8 mm deep.
  for (const char* peg : {"center: [0.107, 0.107, 0.082]", "center: [0.107, 0.107, 0.088]"}) {
    const std::string collider =
        std::string("{name: peg, shape: box, size: [0.008, 0.008, 0.04], ") + peg +
        ", friction: 0.5, enabled: false}";
    const auto fastest = [&](double thickness) {
      Simulator simulator(beside(thickness, collider.c_str(),
                                 "{method: verlet, substeps: 60, gravity: [0, 0, 0]}"));
      simulator.step();
      simulator.enable_collider(0, true);
      double speed = 0;
      for (int frame = 0; frame < 30; ++frame) {
        simulator.step();
        const ClothPart& thin = simulator.scene().cloth.parts[0];
        speed =
            std::max(speed, longest_row(simulator.state().velocities.topRows(thin.num_points())));
      }
      return speed;
    };
    const double alone = fastest(0);
    EXPECT_GT(alone, 0.1);
    // At eight places of each peg up to 6 % apart, as the motion is chaotic; with the clearance of
    // the thick one points would leave at 9 to 17 m/s, not at 0.2 and 1.4.
    EXPECT_NEAR(fastest(0.01), alone, 0.1 * alone) << peg;
  }
}

TEST(Cloths, OfDifferentThicknessArePinchedWhereTheyHaveNoRoom) {
  // Between a floor and a plate: each cloth needs twice its thickness.
  constexpr double thin = 3e-4, thick = 2e-3;
  for (const bool upside_down : {false, true}) {
    for (const double share : {0.95, 1.05}) {
      YAML::Node root = stack(0);
      const double low = upside_down ? thick : thin, high = upside_down ? thin : thick;
      root["cloths"][0]["thickness"] = low;
      root["cloths"][1]["thickness"] = high;
      root["cloths"][0]["origin"] = std::vector<double>{0, 0, low};
      root["cloths"][1]["origin"] = std::vector<double>{0, 0, 2 * low + high};
      const double gap = share * 2 * (thin + thick);
      YAML::Node plate = YAML::Load("{name: plate, shape: box, size: [0.1, 0.1, 0.02]}");
      plate["center"] = std::vector<double>{0.1, 0.1, gap + 0.01};
      plate["friction"] = 0.5;
      root["colliders"].push_back(plate);
      Simulator simulator(read_scene(root));
      int pinched = 0;
      for (int frame = 0; frame < 30; ++frame) pinched = simulator.step().pinched;
      EXPECT_EQ(pinched > 0, share < 1) << share << " " << upside_down;
    }
  }
}

TEST(Cloths, SlipOnEachOtherAtCoulombsAngle) {
  // A towel on another one that is held, both tilted: its acceleration is g (sin - mu cos), with
  // the geometric mean mu of both coefficients.
  for (const auto& frictions : {std::array{0.2, 0.2}, {0.5, 0.5}, {0.9, 0.1}}) {
    const double friction = std::sqrt(frictions[0] * frictions[1]);
    for (const double share : {0.999, 1.001, 1.1}) {  // of the tangent of Coulomb's angle
      YAML::Node root = YAML::Load("{simulation: {method: xpbd, substeps: 10}}");
      const double angle = std::atan(friction * share);
      root["simulation"]["gravity"] =
          std::vector<double>{9.8 * std::sin(angle), 0, -9.8 * std::cos(angle)};
      for (int i = 0; i < 2; ++i) {
        YAML::Node cloth = YAML::Load("{fabric: cotton_towel, damping: 0}");
        cloth["name"] = i == 0 ? "lower" : "upper";
        cloth["width"] = cloth["height"] = i == 0 ? 0.4 : 0.2;
        cloth["columns"] = cloth["rows"] = i == 0 ? 21 : 11;
        cloth["friction"] = frictions[static_cast<std::size_t>(i)];
        cloth["origin"] = std::vector<double>{0.0537 * i, 0.0519 * i, 0.004 * i};
        root["cloths"].push_back(cloth);
      }
      root["cloths"][0]["pinned"] = YAML::Load("[{within: 1, of: [0, 0, 0]}]");
      Simulator simulator(read_scene(root));
      const auto speed = [&] {
        const ClothPart& part = simulator.scene().cloth.parts[1];
        return simulator.state()
            .velocities.middleRows(part.first_point, part.num_points())
            .col(0)
            .mean();
      };
      while (simulator.state().time < 0.3) simulator.step();
      const double start = simulator.state().time, before = speed();
      while (simulator.state().time < 0.6) simulator.step();
      const double acceleration = (speed() - before) / (simulator.state().time - start);
      const double expected = std::max(0.0, 9.8 * (std::sin(angle) - friction * std::cos(angle)));
      EXPECT_NEAR(acceleration, expected, 1e-2 * expected + 1e-5) << friction << " " << share;
      if (share < 1) {
        EXPECT_LT(std::abs(speed()), 1e-6) << friction;
      }
    }
  }
}

TEST(Cloths, APileOf52CardsRests) {
  YAML::Node root = YAML::Load(R"(
colliders: [{name: floor, shape: plane, friction: 0.4}]
simulation: {method: xpbd, substeps: 10}
)");
  constexpr int count = 52;
  constexpr double thickness = 1.5e-3;  // [m] of a card
  const Points shifts = random_points(count, 0.01, 1);
  for (int i = 0; i < count; ++i) {
    YAML::Node card = YAML::Load(
        "{fabric: felt, bending_stiffness: 2.0e-2, density: 0.3, damping: 0.5, friction: 0.3, "
        "thickness: 7.5e-4, width: 0.1, height: 0.1, columns: 4, rows: 4}");
    card["name"] = "card_" + std::to_string(i);
    card["origin"] = std::vector<double>{shifts(i, 0), shifts(i, 1), 0.002 + 0.004 * i};
    root["cloths"].push_back(card);
  }
  Simulator simulator(read_scene(root));
  for (const double end : {2.0, 3.0}) {
    while (simulator.state().time < end) simulator.step();
    EXPECT_LT(rms_velocity(simulator.state()), 2e-3) << end;
    EXPECT_EQ(count_intersections(simulator.cloth(), simulator.state().positions), 0);
  }
  const double height = simulator.state().positions.col(2).maxCoeff();
  EXPECT_NEAR(height, count * thickness, 0.03 * count * thickness);
}

TEST(Cloths, AutoTakesTheMethodOfTheLargest) {
  // A second cloth far away is no larger cloth.
  YAML::Node root = stack(0);
  root.remove("simulation");
  root["cloths"][0]["pinned"] = YAML::Load("[[0, 0]]");
  root["cloths"][0]["origin"] = std::vector<double>{0, 0, 0.5};
  YAML::Node alone = YAML::Clone(root);
  alone["cloths"].remove(1);
  root["cloths"][1]["origin"] = std::vector<double>{50, 0, 0.5};
  const Simulator both(read_scene(root)), one(read_scene(alone));
  EXPECT_EQ(both.choice().method, one.choice().method);
  EXPECT_EQ(both.choice().predicted_error, one.choice().predicted_error);
}

}  // namespace
}  // namespace clothsim::cloths_test
