#include "clothsim/simulation/method_choice.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>

#include "clothsim/model/join_cloths.h"
#include "clothsim/model/make_cloth.h"
#include "clothsim/simulation/substeps.h"
#include "verification/testing.h"

namespace clothsim::method_choice_test {
namespace {

using namespace test;

MethodChoice choice(const Scene& scene) {
  return choose_method(scene.simulation, make_cloth(scene.cloth), scene.colliders);
}

/// pinned2 without its strain limit.
Scene swinging(double ks = 5000, double density = 150) {
  Scene scene = shipped_scene("pinned2");
  scene.cloth.material.ks = ks;
  scene.cloth.material.density = density;
  scene.cloth.material.strain_limit.reset();
  return scene;
}

/// Makes a square of 0.3 m of cotton of it, without a strain limit.
void make_cotton(int side, ClothSpec& cloth) {
  cloth.columns = cloth.rows = side;
  cloth.width = cloth.height = 0.3;
  cloth.material.fabric = Fabric{{1600, 900}, 40, {1.3e-5, 6e-6}, {1e-5, 1e-3}};
  cloth.material.density = 0.12;
  cloth.material.strain_limit.reset();
}

/// The stretch that `softens` tells [%], and the number of substeps with which it is 3 %.
std::pair<int, int> told_stretch(const MethodChoice& chosen) {
  const std::string text = chosen.reasons.text();
  int told = 0, needed = 0;
  EXPECT_TRUE(chosen.reasons.has(Reason::softens));
  EXPECT_EQ(std::sscanf(text.c_str() + std::min(text.find("by some"), text.size()),
                        "by some %d %%, with substeps: %d by 3 %%", &told, &needed),
            2)
      << text;
  return {told, needed};
}

TEST(MethodChoice, ShippedScenesAreExplicit) {
  for (const char* name : {"pinned2", "pinned4", "sphere", "plane", "self_collision"}) {
    const MethodChoice c = choice(shipped_scene(name));
    EXPECT_EQ(c.method, "verlet") << name;
    EXPECT_LT(c.predicted_error.value(), 1e-3) << name;
    EXPECT_LT(c.predicted_cost.value(), 0.5) << name;
    EXPECT_EQ(c.reasons.all(), std::set{Reason::cheapest_within_tolerance}) << name;
  }
}

TEST(MethodChoice, ForetellsWhetherANamedMethodKeepsUp) {
  Scene scene = shipped_scene("sphere");
  for (const char* name : {"bdf2", "implicit_euler"}) {
    scene.simulation.method = name;
    EXPECT_FALSE(choice(scene).is_feasible) << name;
    EXPECT_GT(choice(scene).predicted_cost.value(), 1) << name;
  }
  for (const char* name : {"verlet", "symplectic_euler", "rk4", "xpbd"}) {
    scene.simulation.method = name;
    EXPECT_TRUE(choice(scene).is_feasible) << name;
    EXPECT_LT(choice(scene).predicted_cost.value(), 1) << name;
  }
  const double cost = choice(scene).predicted_cost.value();
  scene.simulation.substeps = 1000 * choice(scene).min_substeps;
  EXPECT_NEAR(choice(scene).predicted_cost.value(), 1000 * cost, 1e-9 * cost);
  EXPECT_FALSE(choice(scene).is_feasible);
}

TEST(MethodChoice, RealFabricIsExplicitToo) {
  Scene scene = shipped_scene("pinned2");
  scene.cloth.material.density = 0.15;
  EXPECT_EQ(choice(scene).method, "verlet");
}

TEST(MethodChoice, TakesAnotherWhereExplicitDoesNotFit) {
  const MethodChoice c = choice(swinging(5e8));
  EXPECT_EQ(c.method, "xpbd");
  EXPECT_LE(c.predicted_cost.value(), 1);
  EXPECT_EQ(c.reasons.all(), std::set{Reason::most_accurate_in_real_time});

  // Verlet's substeps would exceed the limit at any tolerance.
  Scene scene = swinging(5e8);
  scene.simulation.method = "verlet";
  const Cloth cloth = make_grid(scene.cloth);
  EXPECT_GT(count_substeps(cloth, scene.simulation.gravity, cloth.rest_positions, 2, 1.0 / 90),
            1500);
}

TEST(MethodChoice, ATighterToleranceTakesMoreSubstepsThenAHigherOrder) {
  Scene scene = swinging();
  double last_error = 1;
  double last_cost = 0;
  for (const double tolerance : {1e-3, 1e-5, 1e-6, 1e-7, 1e-8}) {
    scene.simulation.tolerance = tolerance;
    const MethodChoice c = choice(scene);
    EXPECT_LE(c.predicted_error.value(), tolerance);
    EXPECT_LE(c.predicted_error.value(), last_error);
    EXPECT_GE(c.predicted_cost.value(), last_cost);
    last_error = c.predicted_error.value();
    last_cost = c.predicted_cost.value();
    EXPECT_EQ(c.method, tolerance > 5e-7 ? "verlet" : "rk4") << tolerance;
  }
}

TEST(MethodChoice, KeepsAGivenCountAndTakesAMethodStableWithIt) {
  for (const bool limited : {false, true}) {
    Scene scene = limited ? shipped_scene("pinned2") : swinging();
    scene.simulation.substeps = 30;
    EXPECT_EQ(choice(scene).method, "verlet");
    scene.simulation.substeps = 2;
    const MethodChoice c = choice(scene);
    EXPECT_EQ(c.method, limited ? "xpbd" : "bdf2");
    EXPECT_EQ(c.min_substeps, 2);
  }
}

TEST(MethodChoice, SaysHowFarXpbdStretchesAHangingMesh) {
  for (const int side : {25, 40}) {
    Scene scene = swinging();
    make_cotton(side, scene.cloth);
    scene.cloth.orientation = Orientation::vertical;
    scene.cloth.material.damping = 3;
    scene.cloth.pinned.clear();
    for (int column = 0; column < side; ++column) {
      scene.cloth.pinned.push_back({column, side - 1, ""});
    }
    scene.simulation.method = "xpbd";
    scene.simulation.substeps = 4;
    EXPECT_FALSE(choice(scene).reasons.has(Reason::softens));  // a grid that pins hold
    scene.cloth = join_cloths({{"mesh", scene.cloth}});
    const auto [told, needed] = told_stretch(choice(scene));
    Simulator simulator(scene);
    for (int frame = 0; frame < 180; ++frame) simulator.step();
    const Points& x = simulator.state().positions;
    double stretch = 0;
    for (int row = 1; row < side; ++row) {
      const int i = row * side + side / 2;
      stretch = std::max(stretch, (x.row(i) - x.row(i - side)).norm() * (side - 1) / 0.3 - 1);
    }
    EXPECT_NEAR(std::log(100 * stretch / told), 0, std::log(1.5)) << told;

    scene.simulation.substeps = needed;
    EXPECT_FALSE(choice(scene).reasons.has(Reason::softens));
    scene.simulation.substeps = 4;
    scene.cloth.material.strain_limit = 0.1;
    EXPECT_FALSE(choice(scene).reasons.has(Reason::softens));
  }
}

TEST(MethodChoice, SaysHowFarXpbdStretchesADrapedGrid) {
  Scene scene = shipped_scene("sphere");
  make_cotton(30, scene.cloth);
  scene.cloth.origin = Vector3(-0.15, -0.15, 0.303);
  scene.cloth.thickness = 5e-4;
  scene.colliders.resize(1);
  scene.colliders[0].shape = Cylinder{0.1, 0.09};
  scene.colliders[0].pose = {{0, 0, 0.25}, Eigen::Quaterniond::Identity()};
  scene.simulation.method = "xpbd";
  for (const int substeps : {5, 8}) {
    scene.simulation.substeps = substeps;
    const auto [told, needed] = told_stretch(choice(scene));
    Simulator simulator(scene);
    const StepReport report = run(simulator, 2);
    EXPECT_NEAR(std::log(100 * report.worst_stretch / told), 0, std::log(2)) << told;
    scene.simulation.substeps = needed;
    EXPECT_FALSE(choice(scene).reasons.has(Reason::softens));
  }
}

TEST(MethodChoice, ANameIsTakenAsItIs) {
  for (const std::string& name : method_names()) {
    Scene scene = swinging(5e7);
    scene.simulation.method = name;
    EXPECT_EQ(choice(scene).method, name);
  }
}

TEST(MethodChoice, ClothWithoutSpringsOrStiffness) {
  Scene scene = swinging(0);
  EXPECT_EQ(choice(scene).method, "verlet");
  scene.cloth.material.springs = {false, false, false};
  EXPECT_EQ(choice(scene).method, "verlet");
}

/// RMS distance over points and frames of half a second, of the cloth's size.
double error_between(const std::vector<Points>& a, const std::vector<Points>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    sum += (a[i] - b[i]).squaredNorm() / static_cast<double>(a[i].rows());
  }
  return std::sqrt(sum / static_cast<double>(a.size()));
}

std::vector<Points> frames(const Scene& scene, int count = 45) {
  Simulator simulator(scene);
  std::vector<Points> result;
  for (int frame = 0; frame < count; ++frame) {
    simulator.step();
    result.push_back(simulator.state().positions);
  }
  return result;
}

/// The error of the scene's own run against a run with eight times the substeps.
double measured_error(const Scene& scene, int substeps, int count) {
  Scene fine = scene;
  fine.simulation.method = "verlet";
  fine.simulation.substeps = 8 * substeps;
  return error_between(frames(scene, count), frames(fine, count));
}

/// The choice of `auto` for so many points along a side, which must be Verlet.
MethodChoice verlet_choice(Scene& scene, int side) {
  scene.cloth.columns = scene.cloth.rows = side;
  const MethodChoice chosen = choice(scene);
  EXPECT_EQ(chosen.method, "verlet");
  return chosen;
}

TEST(MethodChoice, AFallIsExactWhateverTheStep) {
  // With drag, until it lands.
  Scene sphere = shipped_scene("sphere");
  sphere.cloth.material.strain_limit.reset();
  for (const int side : {20, 30}) {
    const MethodChoice chosen = verlet_choice(sphere, side);
    EXPECT_EQ(chosen.predicted_error.value(), 0) << side;
    EXPECT_LT(measured_error(sphere, chosen.min_substeps, 45), 1e-13) << side;
  }

  // In a method of first order, too: 4 m wide, light and stiff.
  Scene light = swinging(1e5, 0.15);
  light.cloth.pinned.clear();
  light.cloth.width = light.cloth.height = 4;
  light.cloth.columns = light.cloth.rows = 33;
  light.cloth.material.damping = 0;
  for (const std::string& method : {std::string("auto"), std::string("xpbd"), std::string("bdf2"),
                                    std::string("implicit_euler")}) {
    light.simulation.method = method;
    Simulator simulator(light);
    for (int frame = 0; frame < 180; ++frame) simulator.step();
    EXPECT_EQ(simulator.choice().predicted_error.value_or(0), 0) << method;
    const double fallen = simulator.state().positions(0, 2) - light.cloth.origin.z();
    EXPECT_NEAR(fallen, -9.8 * 2 * 2 / 2, 1e-9) << method;
  }

  // Nothing below: free fall for ever.
  sphere.colliders.clear();
  EXPECT_EQ(choice(sphere).predicted_error.value(), 0);
}

TEST(MethodChoice, PredictsWhatStandsOnTheGround) {
  // Its columns buckle at once, and faster than any swing, until the folds touch and runs become
  // incomparable.
  Scene fold = shipped_scene("self_collision");
  fold.cloth.material.strain_limit.reset();
  for (const int side : {20, 30}) {
    const MethodChoice chosen = verlet_choice(fold, side);
    const double measured = measured_error(fold, chosen.min_substeps, 22);
    RecordProperty("side " + std::to_string(side),
                   std::to_string(chosen.predicted_error.value() * 1e9) + "e-9 predicted, " +
                       std::to_string(measured * 1e9) + "e-9 measured");
    EXPECT_LT(measured, 3 * chosen.predicted_error.value()) << side;
    EXPECT_GT(measured, chosen.predicted_error.value() / 3) << side;
  }
}

/// A strip of the charted shape, without strain limit, that swings down from one end.
Scene ribbon_of(double ks) {
  Scene ribbon = swinging(ks);
  ribbon.cloth.columns = 3;
  ribbon.cloth.rows = 51;
  ribbon.cloth.width = 0.04;
  ribbon.cloth.pinned = {{0, 0, ""}, {1, 0, ""}, {2, 0, ""}};
  return ribbon;
}

TEST(MethodChoice, PredictsARibbonsErrorAsLongAsItDoesNotRing) {
  double log_ratio = 0;
  const std::vector<double> stiffnesses = {1e6, 1.5e6, 2e6, 2.5e6};
  for (const double ks : stiffnesses) {
    const Scene ribbon = ribbon_of(ks);
    const MethodChoice chosen = choice(ribbon);
    ASSERT_EQ(chosen.method, "verlet");
    const double ratio =
        measured_error(ribbon, chosen.min_substeps, 45) / chosen.predicted_error.value();
    RecordProperty("ks " + std::to_string(ks), std::to_string(ratio) + " times the predicted");
    EXPECT_LT(ratio, 4);
    EXPECT_GT(ratio, 1.0 / 4);
    log_ratio += std::log(ratio) / static_cast<double>(stiffnesses.size());
  }
  EXPECT_LT(std::exp(log_ratio), 3);
  EXPECT_GT(std::exp(log_ratio), 1.0 / 3);
}

TEST(MethodChoice, OfARibbonOfSteelThatRingsNothingIsForetold) {
  for (const double ks : {5e7, 1e9}) {
    const Scene ribbon = ribbon_of(ks);
    const MethodChoice chosen = choice(ribbon);
    EXPECT_EQ(chosen.method, "verlet") << ks;
    EXPECT_EQ(chosen.reasons.all(), std::set{Reason::error_not_predicted}) << ks;
    EXPECT_FALSE(chosen.predicted_error) << ks;
    EXPECT_LT(chosen.predicted_cost.value(), 1) << ks;
    Simulator simulator(ribbon);
    for (int frame = 0; frame < 45; ++frame) {
      const StepReport report = simulator.step();
      EXPECT_EQ(report.reasons.all(), std::set{Reason::error_not_predicted}) << ks;
      EXPECT_EQ(report.recoveries, 0) << ks;
      EXPECT_LT(report.worst_stretch, 1e-3) << ks;
    }
  }
}

TEST(MethodChoice, TakesBdf2ForARibbonWhereExplicitDoesNotFit) {
  const Scene ribbon = ribbon_of(2e10);
  const MethodChoice chosen = choice(ribbon);
  EXPECT_EQ(chosen.method, "bdf2");
  EXPECT_EQ(chosen.reasons.all(), std::set{Reason::cheapest_within_tolerance});
  EXPECT_LT(chosen.predicted_error.value(), ribbon.simulation.tolerance);

  // Damped motion has no growing error. Verlet's substeps need shorter frames.
  constexpr int parts = 2;
  Scene exact = ribbon;
  exact.simulation.method = "verlet";
  exact.simulation.frames_per_second *= parts;
  exact.simulation.substeps = max_substeps;
  const std::vector<Points> all = frames(exact, 15 * parts);
  std::vector<Points> same_times;
  for (std::size_t i = parts - 1; i < all.size(); i += parts) same_times.push_back(all[i]);
  const double measured = error_between(frames(ribbon, 15), same_times);
  EXPECT_LT(measured, 3 * chosen.predicted_error.value());
  EXPECT_GT(measured, chosen.predicted_error.value() / 3);
}

TEST(MethodChoice, OfImpulsesRungeKuttaKnowsNothing) {
  // Within 1e-8 it is the only one on springs alone; any constraint on the cloth rules it out.
  Scene scene = swinging();
  scene.simulation.tolerance = 1e-8;
  EXPECT_EQ(choice(scene).method, "rk4");
  Scene limited = scene;
  limited.cloth.material.strain_limit = 0.1;
  Scene over_ground = scene;
  over_ground.colliders = shipped_scene("plane").colliders;
  Scene folds = scene;
  folds.cloth.self_collision = SelfCollision::points;
  for (const Scene* held : {&limited, &over_ground, &folds}) {
    EXPECT_EQ(choice(*held).method, "verlet");
  }
}

TEST(MethodChoice, ImpulsesWantShortSteps) {
  // 20 x 20 points, whose springs need three substeps in a frame of 11 ms: no more than 3 ms each.
  Scene scene = swinging();
  scene.cloth.columns = scene.cloth.rows = 20;
  scene.cloth.pinned = {{0, 0, ""}};
  const int springs_ask = choice(scene).min_substeps;
  EXPECT_LT(springs_ask, 4);
  scene.cloth.material.strain_limit = 0.1;
  EXPECT_EQ(choice(scene).min_substeps, 4);
  scene.simulation.frames_per_second = 30;
  EXPECT_EQ(choice(scene).min_substeps, 12);
  scene.simulation.method = "verlet";  // named, it needs as many
  EXPECT_EQ(choice(scene).min_substeps, 12);
  EXPECT_EQ(Simulator(scene).step().substeps, 12);
  scene.simulation.substeps = springs_ask;  // the scene's value is kept
  EXPECT_EQ(Simulator(scene).step().substeps, springs_ask);
  scene.simulation.method = "auto";
  EXPECT_EQ(choice(scene).min_substeps, springs_ask);
}

TEST(MethodChoice, OfANamedMethodNothingIsForetold) {
  Scene scene = swinging();
  EXPECT_TRUE(choice(scene).predicted_error);
  scene.simulation.method = "verlet";
  EXPECT_FALSE(choice(scene).predicted_error);
  EXPECT_FALSE(Simulator(scene).step().predicted_error);
}

TEST(MethodChoice, WithoutGravityAnExplicitMethodAndNoErrorForetold) {
  Scene scene = swinging();
  scene.simulation.gravity.setZero();
  const MethodChoice chosen = choice(scene);
  EXPECT_EQ(chosen.method, "verlet");
  EXPECT_TRUE(chosen.reasons.has(Reason::error_not_predicted));
  EXPECT_FALSE(chosen.predicted_error);
  EXPECT_TRUE(chosen.predicted_cost);

  // Where no run is in real time, another method: still no prediction.
  scene.cloth.material.ks = 1e10;
  scene.cloth.columns = scene.cloth.rows = 100;
  const MethodChoice stiff = choice(scene);
  EXPECT_NE(stiff.method, "verlet");
  EXPECT_TRUE(stiff.is_feasible);
  EXPECT_FALSE(stiff.predicted_error);
}

TEST(MethodChoice, ContactCosts) {
  // A substep's cost by the possible contacts, the cheapest first.
  const auto cost = [](SelfCollision self, const std::vector<ColliderSpec>& colliders) {
    Scene scene = swinging();
    scene.cloth.self_collision = self;
    scene.colliders = colliders;
    scene.simulation.substeps = 10;
    return choice(scene).predicted_cost.value();
  };
  const std::vector<ColliderSpec> plane = shipped_scene("plane").colliders;
  const std::vector<ColliderSpec> table = shipped_scene("table").colliders;
  const double nothing = cost(SelfCollision::off, {});
  const double points = cost(SelfCollision::points, {});
  const double ground = cost(SelfCollision::off, plane);  // points alone
  const double edges = cost(SelfCollision::off, table);   // faces, too
  EXPECT_LT(nothing, points);
  EXPECT_EQ(points, ground);
  EXPECT_LT(ground, edges);
  EXPECT_NEAR(cost(SelfCollision::points, plane), points + ground - nothing, 1e-12);
  EXPECT_GT(cost(SelfCollision::surface, {}), 2 * points);
}

TEST(MethodChoice, WhereContactIsTheCostFewerSubstepsWin) {
  // A tolerance that XPBD meets too, with five substeps where Verlet needs fifteen: more expensive
  // on springs alone, cheaper where each substep finds contacts.
  Scene scene = shipped_scene("table");
  scene.cloth.material.ks = 3e4;
  scene.cloth.material.strain_limit.reset();
  scene.simulation.tolerance = 1e-2;
  EXPECT_EQ(choice(scene).method, "xpbd");
  scene.simulation.tolerance = 1e-3;
  EXPECT_EQ(choice(scene).method, "verlet");
  scene.simulation.tolerance = 1e-2;
  scene.colliders.clear();
  scene.cloth.pinned = {{0, 0, ""}, {49, 0, ""}};
  EXPECT_EQ(choice(scene).method, "verlet");
}

TEST(MethodChoice, ForTheSameCostSpringsAreAsStiffAsTheyAreNamed) {
  // XPBD with four substeps for Verlet's eight: 1.0 and 1.2 CPU seconds for three of a table, with
  // springs stretched by 14 and 4 %.
  Scene scene = shipped_scene("table");
  scene.cloth.material.ks = 1e4;
  scene.cloth.material.strain_limit.reset();
  scene.simulation.tolerance = 1e-2;
  const MethodChoice chosen = choice(scene);
  EXPECT_EQ(chosen.method, "verlet");
  EXPECT_EQ(chosen.reasons.all(), std::set{Reason::cheapest_within_tolerance});
}

TEST(MethodChoice, PredictedErrorIsTheMeasuredOneWithinAFactorOfThree) {
  struct Case {
    double ks;
    double density;
    int side;
    double tolerance;
  };
  for (const Case& c : {Case{5000, 150, 50, 1e-3},
                        {5e5, 150, 50, 1e-3},
                        {2e6, 150, 50, 1e-3},
                        {5e8, 150, 50, 1e-3},
                        {5000, 0.15, 30, 1e-3},
                        {5000, 150, 25, 1e-6},
                        {5000, 150, 50, 1e-7}}) {
    Scene scene = swinging(c.ks, c.density);
    scene.cloth.columns = scene.cloth.rows = c.side;
    scene.cloth.pinned = {{0, 0, ""}, {c.side - 1, 0, ""}};
    scene.simulation.tolerance = c.tolerance;
    const MethodChoice chosen = choice(scene);

    // Verlet with steps so short that its own error is a fiftieth of the prediction.
    Scene fine = scene;
    fine.simulation.method = c.tolerance < 1e-6 ? "rk4" : "verlet";
    const Cloth cloth = make_grid(scene.cloth);
    const int needed =
        count_substeps(cloth, scene.simulation.gravity, cloth.rest_positions, 2, 1.0 / 90);
    fine.simulation.substeps = chosen.method == "xpbd" ? needed : 8 * chosen.min_substeps;
    const double measured = error_between(frames(scene), frames(fine));
    const std::string what = chosen.method + " ks " + std::to_string(c.ks) + " side " +
                             std::to_string(c.side) + " tolerance " + std::to_string(c.tolerance);
    RecordProperty(what, std::to_string(chosen.predicted_error.value() * 1e9) + "e-9 predicted, " +
                             std::to_string(measured * 1e9) + "e-9 measured");
    EXPECT_LT(measured, 3 * chosen.predicted_error.value()) << what;
    EXPECT_GT(measured, chosen.predicted_error.value() / 3) << what;
  }
}

}  // namespace
}  // namespace clothsim::method_choice_test
