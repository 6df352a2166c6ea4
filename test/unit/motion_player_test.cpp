#include "clothsim/run/motion_player.h"

#include <gtest/gtest.h>

#include <fstream>

#include "clothsim/model/npz.h"
#include "says.h"
#include "scene_text.h"
#include "state_testing.h"
#include "temporary_folder.h"

namespace clothsim::motion_player_test {
namespace {

using test::expect_same;

constexpr const char* base = R"(
cloth: {columns: 8, rows: 8, pinned: [{point: [0, 0], frame: hand}]}
colliders:
  - {name: ball, shape: sphere, center: [0.5, 0.5, 0.7], radius: 0.2, friction: 0.5, frame: ball}
simulation: {frames_per_second: 100}
motions: )";

Scene scene(const std::string& motions) { return read_scene(YAML::Load(base + motions)); }

std::string refused(const std::string& motions) { return refusal(base + motions); }

/// The message that refuses to play `frames` frames.
std::string refused_when_played(const std::string& motions, int frames,
                                const std::filesystem::path& folder = ".") {
  try {
    Simulator simulator(scene(motions));
    MotionPlayer player(simulator, folder);
    for (int k = 0; k < frames; ++k) {
      player.play(simulator);
      simulator.step();
    }
  } catch (const InvalidValue& error) {
    return error.what();
  }
  return "accepted";
}

TEST(MotionPlayer, MovesFramesAsTargetsDo) {
  Simulator played(
      scene("[{time: 0.1, frame: ball, position: [0.5, 0.5, 0.75]}, {time: 0.3, frame: ball, "
            "position: [0.6, 0.5, 0.8], rpy: [0, 0, 1]}, {time: 0.15, frame: hand, position: [0, "
            "0, 1]}, {time: 0.25, frame: hand, position: [0, 0, 1.1], linear: [0, 0, 0.5]}]"));
  Simulator by_hand(scene("[]"));
  MotionPlayer player(played, ".");
  EXPECT_EQ(player.duration(), 0.3);
  DrivenFrames driven;
  const auto at = [](const Vector3& place) { return FrameTarget{{place}}; };
  for (int k = 0; k < 40; ++k) {
    player.play(played);
    if (k == 0) driven.set_targets({{"ball", at({0.5, 0.5, 0.75})}}, 10, by_hand);
    if (k == 0) driven.set_targets({{"hand", at({0, 0, 1})}}, 15, by_hand);
    if (k == 10) {
      FrameTarget turned = at({0.6, 0.5, 0.8});
      turned.pose.orientation = Eigen::AngleAxisd(1, Vector3::UnitZ());
      driven.set_targets({{"ball", turned}}, 20, by_hand);
    }
    if (k == 15) {
      FrameTarget fast = at({0, 0, 1.1});
      fast.twist = Twist{{0, 0, 0.5}, {0, 0, 0}};
      driven.set_targets({{"hand", fast}}, 10, by_hand);
    }
    driven.move(by_hand);
    played.step();
    by_hand.step();
    expect_same(played.state(), by_hand.state());
  }
  EXPECT_EQ(played.collider_pose(0).position, Vector3(0.6, 0.5, 0.8));
  EXPECT_LT((played.state().positions.row(0) - Eigen::RowVector3d(0, 0, 1.1)).norm(), 1e-12);
}

TEST(MotionPlayer, AKeyFrameAtTheStartPutsTheFrameThere) {
  Simulator simulator(
      scene("[{time: 0, frame: ball, position: [9, 9, 9]},"
            " {time: 0.1, frame: ball, position: [9, 9, 10]}]"));
  MotionPlayer player(simulator, ".");
  player.play(simulator);
  simulator.step();
  EXPECT_LT((simulator.collider_pose(0).position - Vector3(9, 9, 9.1)).norm(), 1e-14);
}

TEST(MotionPlayer, EventsComeInTheirFrames) {
  Simulator simulator(
      scene("[{time: 0.05, attach: ball, points: [63]}, {time: 0.1, detach: ball}, {time: 0.02, "
            "disable: ball}, {time: 0.04, enable: ball}, {time: 0.03, set: {ks: 700, gravity: [0, "
            "0, -1], strain_limit: off,   springs: {shear: false}}}, {time: 0.2, frame: hand, "
            "position: [0, 0, 1]}, {time: 0.12, attach: hand, radius: 0.2}]"));
  MotionPlayer player(simulator, ".");
  for (int k = 0; k < 14; ++k) {
    player.play(simulator);
    EXPECT_EQ(simulator.collider_enabled(0), k < 2 || k >= 4) << k;
    EXPECT_EQ(simulator.scene().cloth.material.ks, k < 3 ? 5000 : 700) << k;
    EXPECT_EQ(simulator.scene().simulation.gravity.z(), k < 3 ? -9.8 : -1) << k;
    EXPECT_EQ(simulator.scene().cloth.material.strain_limit.has_value(), k < 3) << k;
    EXPECT_EQ(simulator.scene().cloth.material.springs[1], k < 3) << k;
    EXPECT_TRUE(simulator.scene().cloth.material.springs[0]);
    EXPECT_EQ(simulator.grips().count("ball"), k >= 5 && k < 10 ? 1u : 0u) << k;
    EXPECT_EQ(simulator.grips().count("hand"), k >= 12 ? 1u : 0u) << k;
    simulator.step();
  }
}

TEST(MotionPlayer, ReadsFiles) {
  const test::TemporaryFolder folder("motions");
  std::ofstream(folder.path() / "a.csv") << "time,x,y,z\n0,0.5,0.5,0.7\r\n0.1,0.5,0.5,0.8\n";
  std::ofstream(folder.path() / "turned.csv")
      << "time,x,y,z,qx,qy,qz,qw\n0,0.5,0.5,0.7,0,0,0,1\n0.1,0.5,0.5,0.8,0,0,2,2\n";
  write_npz(folder.path() / "a.npz",
            {{"time", to_npy(NumberArray{{2}, {0, 0.1}})},
             {"position", to_npy(NumberArray{{2, 3}, {0.5, 0.5, 0.7, 0.5, 0.5, 0.8}})},
             {"orientation", to_npy(NumberArray{{2, 4}, {0, 0, 0, 1, 0, 0, 2, 2}})}});
  for (const std::string name : {"a.csv", "turned.csv", "a.npz"}) {
    Simulator simulator(scene("[{file: " + name + ", frame: ball}]"));
    MotionPlayer player(simulator, folder.path());
    for (int k = 0; k < 10; ++k) {
      player.play(simulator);
      simulator.step();
    }
    EXPECT_EQ(simulator.collider_pose(0).position, Vector3(0.5, 0.5, 0.8)) << name;
    const double angle = name == "a.csv" ? 0 : M_PI / 2;
    EXPECT_NEAR(Eigen::AngleAxisd(simulator.collider_pose(0).orientation).angle(), angle, 1e-7);
  }
}

TEST(MotionPlayer, RefusesFiles) {
  const test::TemporaryFolder folder("motions");
  const auto refused_file = [&](const std::string& name, const std::string& text) {
    std::ofstream(folder.path() / name) << text;
    return refused_when_played("[{file: " + name + ", frame: ball}]", 1, folder.path());
  };
  const std::string csv = "time,x,y,z\n";
  const std::vector<std::array<std::string, 3>> mistakes = {
      {"a.csv", "", "... got nothing"},
      {"b.csv", "t,x,y,z\n0,0,0,0\n", "... got \"t,x,y,z\" ... time,x,y,z"},
      {"c.csv", csv, "... got 0 key"},
      {"d.csv", csv + "0,0,0\n", "... .2: got \"0,0,0\" ... 4"},
      {"e.csv", csv + "0,0,0,0\n1,0,0,nan\n", "... 1.position.2: got nan"},
      {"f.csv", csv + "-1,0,0,0\n", "... 0.time: got -1"},
      {"g.csv", csv + "0,0,0,0\n0.001,0,0,0\n", "... time: got 0.001 ... same frame"},
      {"h.txt", csv, "... got ... kind"},
      {"i.npz", "no zip", "... NPZ"}};
  for (const auto& [name, text, message] : mistakes) {
    EXPECT_TRUE(says(refused_file(name, text), message));
  }
  EXPECT_NE(refused_when_played("[{file: none.csv, frame: ball}]", 1).find("no regular file"),
            std::string::npos);
}

TEST(MotionPlayer, RefusesEntries) {
  const std::vector<std::array<std::string, 2>> mistakes = {
      {"5", "motions: got 5 ... list"},
      {"[5]", "motions.0: got 5 ... map"},
      {"[{time: 1}]", "motions.0: got none ... file, frame, attach"},
      {"[{frame: ball}]", "motions.0.position: got nothing"},
      {"[{frame: ball, position: [0, 0]}]", "motions.0.position: got [0, 0]"},
      {"[{frame: /ball, position: [0, 0, 0]}]", "motions.0.frame.frame: got \"/ball\""},
      {"[{frame: ball, position: [0, 0, 0], rpy: [0, 0, 0], orientation: [0, 0, 0, 1]}]",
       "motions.0.rpy: got ... orientation ... again"},
      {"[{frame: ball, position: [0, 0, 0], orientation: [0, 0, 0, 0]}]", "motions.0.orientation"},
      {"[{frame: ball, position: [0, 0, 0], time: -1}]", "motions.0.time: got -1"},
      {"[{frame: ball, position: [0, 0, 0], attach: ball}]", "motions.0.attach: got ... unknown"},
      {"[{attach: hand}]", "motions.0.points: got none ... no radius"},
      {"[{attach: hand, points: [1], radius: 1}]", "motions.0.points: got points ... radius"},
      {"[{attach: hand, points: [64]}]", "motions.0.points.0: got 64"},
      {"[{enable: moon}]", "motions.0.enable: got \"moon\" ... ball"},
      {"[{set: {ks: -1}}]", "motions.0.set.ks: got -1"},
      {"[{set: {columns: 3}}]", "motions.0.set.columns: got ... unknown"}};
  for (const auto& [motions, message] : mistakes) EXPECT_TRUE(says(refused(motions), message));
  EXPECT_NE(refused_when_played("[{frame: ball, position: [0, 0, 0], time: 0.5},"
                                " {frame: ball, position: [0, 0, 1], time: 0.502}]",
                                1)
                .find("motions.1.time: got 0.502"),
            std::string::npos);
  EXPECT_NE(refused_when_played("[{attach: claw, points: [1]}]", 1).find("motions.0.attach"),
            std::string::npos);
  EXPECT_NE(refused_when_played("[{attach: ball, radius: 0.01}]", 1).find("motions.0.radius"),
            std::string::npos);
}

}  // namespace
}  // namespace clothsim::motion_player_test
