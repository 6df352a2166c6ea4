// The headless runner as a user runs it: its command line, exit codes and files.

#include <gtest/gtest.h>
#include <pty.h>
#include <sys/wait.h>
#include <unistd.h>
#include <utmp.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include "clothsim/model/npz.h"
#include "says.h"
#include "temporary_folder.h"

namespace clothsim::simulate_test {
namespace {

namespace fs = std::filesystem;

struct Result {
  int exit_code;
  std::string out;
  std::string err;
};

std::string read(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

class Simulate : public testing::Test {
 protected:
  void SetUp() override {
    scene_ = write("scene.yaml", "cloth: {columns: 6, rows: 5, pinned: [[0, 0]]}\n");
  }

  fs::path write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }

  /// Runs simulate with `arguments`, as a shell splits them.
  Result run(const std::string& arguments) const {
    const fs::path out = folder_ / "stdout", err = folder_ / "stderr";
    const std::string command = std::string(CLOTHSIM_SIMULATE) + " " + arguments + " >" +
                                out.string() + " 2>" + err.string();
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read(out), read(err)};
  }

  const clothsim::test::TemporaryFolder temporary_{"simulate"};
  const fs::path folder_ = temporary_.path();
  std::string scene_;
};

TEST_F(Simulate, WritesWhatItPromises) {
  const fs::path output = folder_ / "a" / "b";
  const Result result = run(scene_ + " --seconds 0.1 --every 0.05 --output " + output.string() +
                            " --set cloth.ks=500 --set simulation.frames_per_second=100");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err, "");  // no progress bar in a pipe
  EXPECT_EQ(result.out, read(output / "report.yaml"));

  // final.csv: a header and a line of six numbers for each point.
  std::istringstream csv(read(output / "final.csv"));
  std::string line;
  std::getline(csv, line);
  EXPECT_EQ(line, "x,y,z,vx,vy,vz");
  int points = 0;
  while (std::getline(csv, line)) {
    std::array<double, 6> v;
    ASSERT_EQ(std::sscanf(line.c_str(), "%lf,%lf,%lf,%lf,%lf,%lf", &v[0], &v[1], &v[2], &v[3],
                          &v[4], &v[5]),
              6);
    for (const double number : v) EXPECT_TRUE(std::isfinite(number));
    if (points == 0) {  // the pin
      EXPECT_EQ(line, "0,0,1,0,0,0");
    } else {
      EXPECT_LT(v[2], 1);
    }
    ++points;
  }
  EXPECT_EQ(points, 30);

  // Every fifth frame, the start included.
  std::set<std::string> frames;
  for (const auto& entry : fs::directory_iterator(output / "frames")) {
    frames.insert(entry.path().filename());
  }
  EXPECT_EQ(frames, (std::set<std::string>{"000000.ply", "000005.ply", "000010.ply"}));

  const YAML::Node report = YAML::LoadFile(output / "report.yaml");
  EXPECT_EQ(report["scene"].as<std::string>(), scene_);
  EXPECT_EQ(report["overrides"][0].as<std::string>(), "cloth.ks=500");
  EXPECT_EQ(report["method"].as<std::string>(), "verlet");
  EXPECT_GE(report["substeps"].as<int>(), 1);
  EXPECT_EQ(report["frames"].as<int>(), 10);
  EXPECT_NEAR(report["simulated_seconds"].as<double>(), 0.1, 1e-12);
  EXPECT_GT(report["wall_seconds"].as<double>(), 0);
  EXPECT_GT(report["cpu_seconds"].as<double>(), 0);
  EXPECT_GE(report["worst_stretch"].as<double>(), report["mean_stretch"].as<double>());
  EXPECT_GT(report["rms_velocity"].as<double>(), 0);
  EXPECT_GT(report["energy"]["kinetic"].as<double>(), 0);
  EXPECT_GT(report["energy"]["elastic"].as<double>(), 0);
  EXPECT_GT(report["energy"]["gravitational"].as<double>(), 0);
  EXPECT_EQ(report["contacts"].as<int>(), 0);
  EXPECT_EQ(report["intersecting_pairs"].as<int>(), 0);
  EXPECT_EQ(report["deepest_penetration"].as<double>(), 0);
  EXPECT_FALSE(report["diverged"].as<bool>());
}

TEST_F(Simulate, GoesOnFromAStateToTheSameBits) {
  const auto out = [&](const std::string& name) { return (folder_ / name).string(); };
  const auto runs = [&](const std::string& arguments) {
    const Result result = run(scene_ + arguments);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return result.err;
  };
  runs(" --seconds 0.4 --every 0.2 --output " + out("whole"));
  runs(" --seconds 0.2 --output " + out("first"));
  EXPECT_EQ(runs(" --seconds 0.2 --from " + out("first/final.npz") + " --output " + out("second")),
            "");
  EXPECT_EQ(read(folder_ / "second/final.csv"), read(folder_ / "whole/final.csv"));

  // The frames hold the same states; with another cloth the run continues without a memory.
  const auto frames = clothsim::read_npz(folder_ / "whole" / "frames.npz");
  EXPECT_EQ(frames.at("positions").shape, (std::vector<std::size_t>{3, 30, 3}));
  EXPECT_EQ(frames.at("triangles").shape, (std::vector<std::size_t>{40, 3}));
  EXPECT_NEAR(frames.at("times").values[2], 0.4, 1e-12);
  const auto last = clothsim::read_npz(folder_ / "whole" / "final.npz").at("positions").values;
  EXPECT_TRUE(std::equal(last.begin(), last.end(), frames.at("positions").values.begin() + 2 * 90));
  EXPECT_FALSE(fs::exists(folder_ / "whole" / "frames.npz.times.part"));
  EXPECT_NE(runs(" --seconds 0.1 --set simulation.method=bdf2 --from " + out("first/final.npz"))
                .find("without a memory"),
            std::string::npos);

  for (const auto& [set, message] :
       {std::pair("cloth.columns=7", "positions: got 30 points"), std::pair("cloth.ks=500", "")}) {
    const Result result =
        run(scene_ + " --seconds 0.1 --from " + out("first/final.npz") + " --set " + set);
    EXPECT_EQ(result.exit_code, *message ? 1 : 0);
    EXPECT_NE(result.err.find(message), std::string::npos) << result.err;
  }
  EXPECT_NE(run(scene_ + " --seconds 0.1 --from " + scene_).err.find("expected an NPZ file"),
            std::string::npos);
}

TEST_F(Simulate, PlaysMotions) {
  const std::string scene =
      write("moving.yaml",
            "cloth: {columns: 6, rows: 5, pinned: [{point: [0, 0], frame: hand}]}\n"
            "motions: [{frame: hand, position: [0, 0, 1]}, {file: up.csv, frame: hand}]\n");
  write("up.csv", "time,x,y,z\n0.3,0,0,1.25\n");
  const Result result = run(scene + " --output " + folder_.string());
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  EXPECT_EQ(YAML::Load(result.out)["frames"].as<int>(), 27);
  EXPECT_EQ(clothsim::read_npz(folder_ / "final.npz").at("positions").values[2], 1.25);
  EXPECT_NE(run(scene_).err.find("--seconds: got nothing"), std::string::npos);

  // Pins that were moved stay at their places in the state.
  const Result on =
      run(scene + " --seconds 0.05 --set motions=[] --from " + (folder_ / "final.npz").string() +
          " --output " + (folder_ / "on").string());
  ASSERT_EQ(on.exit_code, 0) << on.err;
  EXPECT_EQ(clothsim::read_npz(folder_ / "on" / "final.npz").at("positions").values[2], 1.25);
}

TEST_F(Simulate, CollidersGoOnFromWhereTheyWere) {
  // A ball has gone up to the cloth in 0.3 s, turned, and stays.
  const std::string scene =
      write("ball.yaml",
            "cloth: {columns: 8, rows: 8, ks: 500}\n"
            "colliders: [{name: ball, shape: box, size: [0.3, 0.3, 0.3], center: [0.5, 0.5, 0.6],"
            " friction: 0.5, frame: ball}]\n"
            "motions: [{time: 0.3, frame: ball, position: [0.5, 0.5, 0.8], rpy: [0.3, 0, 1]}]\n");
  const std::string still =
      " --set motions=[] --seconds 0.3 --from " + (folder_ / "first/final.npz").string();
  for (const auto& [name, arguments] :
       {std::pair<std::string, std::string>("whole", " --seconds 0.6"),
        {"first", ""},
        {"second", still}}) {
    ASSERT_EQ(run(scene + arguments + " --output " + (folder_ / name).string()).exit_code, 0);
  }
  EXPECT_EQ(read(folder_ / "second/final.csv"), read(folder_ / "whole/final.csv"));
  EXPECT_EQ(clothsim::read_npz(folder_ / "second/final.npz").at("colliders").values[2], 0.8);
  EXPECT_NE(run(scene + still + " --set colliders=[]").err.find("the state has 1 colliders"),
            std::string::npos);
}

TEST_F(Simulate, FramesAreThoseOfTheLastRun) {
  const auto frames_of = [&](const char* seconds) {
    const Result result =
        run(scene_ + " --every 0.01 --seconds " + seconds + " --output " + folder_.string());
    EXPECT_EQ(result.exit_code, 0) << result.err;
    const std::filesystem::directory_iterator frames(folder_ / "frames");
    return std::distance(begin(frames), end(frames));
  };
  EXPECT_EQ(frames_of("0.1"), 10);
  std::ofstream(folder_ / "frames" / "mesh.ply") << "the user's own";
  EXPECT_EQ(frames_of("0.02"), 3 + 1);
  EXPECT_TRUE(std::filesystem::exists(folder_ / "frames" / "mesh.ply"));
}

TEST_F(Simulate, FramesArePlyOfTheGrid) {
  const Result result = run(scene_ + " --seconds 0.02 --every 0.01 --output " + folder_.string());
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const std::string ply = read(folder_ / "frames" / "000000.ply");
  const std::string end = "end_header\n";
  const size_t body = ply.find(end) + end.size();
  EXPECT_NE(ply.find("element vertex 30\n"), std::string::npos);
  EXPECT_NE(ply.find("element face 40\n"), std::string::npos);
  ASSERT_EQ(ply.size(), body + 30 * 24 + 40 * 13);

  std::array<double, 3> last;
  std::memcpy(last.data(), ply.data() + body + 29 * 24, 24);
  EXPECT_EQ(last, (std::array<double, 3>{1, 1, 1}));
  for (size_t face = 0; face < 40; ++face) {
    const char* bytes = ply.data() + body + 30 * 24 + face * 13;
    std::array<int, 3> ids;
    std::memcpy(ids.data(), bytes + 1, 12);
    EXPECT_EQ(bytes[0], 3);
    for (const int id : ids) EXPECT_TRUE(id >= 0 && id < 30) << id;
  }
}

TEST_F(Simulate, SameInputGivesSameBits) {
  const std::string scene = std::string(CLOTHSIM_SCENES_DIR) + "/self_collision.yaml";
  std::string finals[2];
  for (std::string& final : finals) {
    const Result result = run(scene + " --seconds 0.5 --output " + folder_.string());
    ASSERT_EQ(result.exit_code, 0) << result.err;
    final = read(folder_ / "final.csv");
  }
  EXPECT_GT(finals[0].size(), 2500u * 20);
  EXPECT_EQ(finals[0], finals[1]);

  const Result other =
      run(scene + " --seconds 0.5 --set simulation.seed=2 --output " + folder_.string());
  EXPECT_EQ(other.exit_code, 0);
  EXPECT_NE(read(folder_ / "final.csv"), finals[0]);
}

TEST_F(Simulate, CountsTrianglesThatCross) {
  // Without self collision the falling cloth passes through itself.
  const Result result = run(std::string(CLOTHSIM_SCENES_DIR) +
                            "/self_collision.yaml --seconds 0.5 --set cloth.self_collision=false");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_GT(YAML::Load(result.out)["intersecting_pairs"].as<int>(), 100);
}

TEST_F(Simulate, TellsOfAStateThatCrossesItselfAndTakesItApart) {
  // A towel whose right half lies on the left one, and at its free edge below it.
  const fs::path folded = write("folded.py", R"(
import sys
import numpy as np
n = 12
x, y = np.meshgrid(np.linspace(0, 0.4, n), np.linspace(0, 0.4, n))
z = np.full_like(x, 0.01)
over = x > 0.2
z[over] += 0.01 - 0.02 * np.maximum(0, x[over] - 0.3) / 0.1
x[over] = 0.4 - x[over]
np.savez(sys.argv[1], positions=np.stack([x, y, z], axis=-1).reshape(-1, 3), velocities=np.zeros((n * n, 3)))
)");
  const std::string state = (folder_ / "folded.npz").string();
  ASSERT_EQ(std::system(("/usr/bin/python3 " + folded.string() + " " + state).c_str()), 0);
  const std::string towel =
      write("towel.yaml",
            "cloth: {width: 0.4, height: 0.4, columns: 12, rows: 12, thickness: 0.002, "
            "self_collision: surface}\n")
          .string();
  const std::string arguments = towel + " --seconds 0.1 --from " + state;

  const Result crossed = run(arguments);
  EXPECT_EQ(crossed.exit_code, 0);
  EXPECT_NE(crossed.err.find("simulate: the state crosses itself in "), std::string::npos);
  EXPECT_NE(crossed.err.find("cloth.untangle=true"), std::string::npos);
  EXPECT_GT(YAML::Load(crossed.out)["intersecting_pairs"].as<int>(), 0);
  EXPECT_NE(YAML::Load(crossed.out)["reason"].as<std::string>().find("crosses itself"),
            std::string::npos);

  const Result apart = run(arguments + " --set cloth.untangle=true");
  EXPECT_EQ(apart.exit_code, 0);
  EXPECT_EQ(apart.err, "");
  EXPECT_EQ(YAML::Load(apart.out)["intersecting_pairs"].as<int>(), 0);
}

TEST_F(Simulate, RoundsToWholeFrames) {
  for (const auto& [seconds, frames] :
       {std::pair("1e-6", 1), std::pair("0.016", 1), std::pair("0.02", 2), std::pair("1", 90)}) {
    const Result result = run(scene_ + " --seconds " + seconds);
    EXPECT_EQ(YAML::Load(result.out)["frames"].as<int>(), frames) << seconds;
  }
}

TEST_F(Simulate, RefusesBadInputWithExitOneAndAMessage) {
  const std::string good = scene_ + " --seconds 0.1";
  const std::string broken = write("broken.yaml", "cloth: [");
  const std::string typo = write("typo.yaml", "cloth: {kss: 5}");
  const std::string blocked = write("file", "");
  const struct {
    std::string arguments;
    std::string message;  // part of standard error, as says() takes it
  } cases[] = {
      {"", "required"},
      {scene_, "--seconds: got nothing ... time [s] ... motions"},
      {"--seconds 1", "scene is required"},
      {good + " --fast", "--fast"},
      {"no_such.yaml --seconds 1", "no_such.yaml: got No such file or directory"},
      {folder_.string() + " --seconds 1", "got Is a directory ... regular file"},
      {broken + " --seconds 1", "YAML"},
      {typo + " --seconds 1", "cloth.kss: got ... unknown ... width"},
      {scene_ + " --seconds 0", "--seconds: got 0 ... least"},
      {scene_ + " --seconds -1", "--seconds: got -1"},
      {scene_ + " --seconds nan", "--seconds: got nan ... finite"},
      {scene_ + " --seconds inf", "--seconds: got inf ... finite"},
      {scene_ + " --seconds 1e99", "--seconds: got 1e+99 ... most"},
      {scene_ + " --seconds soon", "--seconds"},
      {good + " --set cloth.ks=-5", "cloth.ks: got -5 ... least 0 [N/m]"},
      {good + " --set 'cloth.ks=5\n---\n6'", "cloth.ks: got more ... document"},
      {good + " --set cloth.ks", "got \"cloth.ks\" ... path.to.key=value"},
      {good + " --set cloth.bend=1", "cloth.bend: got ... unknown"},
      {good + " --every 0.1", "--output"},
      {good + " --every 0 --output " + folder_.string(), "--every: got 0"},
      {good + " --output " + blocked + "/deeper", blocked},
      {good + " --output " + blocked, blocked},
  };
  for (const auto& c : cases) {
    const Result result = run(c.arguments);
    EXPECT_EQ(result.exit_code, 1) << c.arguments;
    EXPECT_TRUE(clothsim::says(result.err, "... " + c.message)) << c.arguments;
  }
}

// A limit on the size of files stands for a full disk: a write fails halfway.
TEST_F(Simulate, AFullDiskLeavesTheFilesOfTheLastRun) {
  const std::string arguments = scene_ + " --seconds 0.1 --output " + folder_.string();
  ASSERT_EQ(run(arguments).exit_code, 0);
  const std::string before = read(folder_ / "final.csv");
  ASSERT_GT(before.size(), 1024u);  // a block of ulimit

  const std::string limited = "trap '' XFSZ; ulimit -f 1; " + std::string(CLOTHSIM_SIMULATE) + " " +
                              arguments + " --set cloth.ks=50 2>" + (folder_ / "err").string();
  EXPECT_NE(std::system(("bash -c \"" + limited + "\"").c_str()), 0);
  const std::string message = read(folder_ / "err");
  EXPECT_NE(message.find("final.csv: File too large"), std::string::npos) << message;
  EXPECT_EQ(read(folder_ / "final.csv"), before);
  EXPECT_FALSE(fs::exists(folder_ / "final.csv.part"));

  const std::string to_full =
      std::string(CLOTHSIM_SIMULATE) + " " + scene_ + " --seconds 0.1 >/dev/full 2>/dev/null";
  EXPECT_NE(std::system(to_full.c_str()), 0);
}

TEST_F(Simulate, TellsThatFramesStayStill) {
  const std::string scene =
      write("frames.yaml",
            "cloth: {columns: 6, rows: 5, pinned: [{point: [0, 0], frame: a}]}\n"
            "colliders: [{shape: sphere, frame: b}, {shape: plane}]\n");
  const Result result = run(scene + " --seconds 0.01");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.err,
            "simulate: without ROS no tf frame moves: what follows one stays still (colliders: 1, "
            "pins: 1)\n");
}

TEST_F(Simulate, DivergedEndsWithTwoAndTheLastGoodFrame) {
  // One substep of Verlet at a thousand times its stiffness limit.
  const Result result = run(scene_ +
                            " --seconds 5 --set cloth.ks=1e9 --set simulation.substeps=1 --set "
                            "simulation.method=verlet --set cloth.strain_limit=off --output " +
                            folder_.string());
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_NE(result.err.find("diverged in frame"), std::string::npos) << result.err;

  const YAML::Node report = YAML::LoadFile(folder_ / "report.yaml");
  EXPECT_TRUE(report["diverged"].as<bool>());
  EXPECT_NE(report["error"].as<std::string>().find("with method verlet and 1 substeps a frame"),
            std::string::npos);
  EXPECT_LT(report["frames"].as<int>(), 450);
  EXPECT_NEAR(report["simulated_seconds"].as<double>(), report["frames"].as<int>() / 90.0, 1e-9);
  const std::string csv = read(folder_ / "final.csv");
  EXPECT_EQ(csv.find("nan"), std::string::npos);
  EXPECT_EQ(csv.find("inf"), std::string::npos);
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 31);
}

TEST_F(Simulate, ShowsAProgressBarOnATerminal) {
  int terminal = -1, line = -1;
  ASSERT_EQ(openpty(&terminal, &line, nullptr, nullptr, nullptr), 0);
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    login_tty(line);
    execl("/bin/sh", "sh", "-c", "\"$0\" \"$1\" --seconds 1; status=$?; echo is-over; exit $status",
          CLOTHSIM_SIMULATE, scene_.c_str(), nullptr);
    _exit(127);
  }
  // A terminal whose other end has been closed may lose the last output: `line` stays open.
  std::string shown;
  std::array<char, 4096> buffer;
  while (shown.find("is-over") == std::string::npos) {
    const ssize_t n = ::read(terminal, buffer.data(), buffer.size());
    ASSERT_GT(n, 0) << std::strerror(errno);
    shown.append(buffer.data(), static_cast<size_t>(n));
  }
  int status = 0;
  waitpid(child, &status, 0);
  close(terminal);
  close(line);
  EXPECT_EQ(WEXITSTATUS(status), 0);
  EXPECT_NE(shown.find("0/90"), std::string::npos) << shown;
  EXPECT_NE(shown.find("frames: 90"), std::string::npos) << shown;
}

TEST_F(Simulate, HelpNamesEveryOption) {
  const Result result = run("--help");
  EXPECT_EQ(result.exit_code, 0);
  for (const char* option : {"--seconds", "--set", "--every", "--output", "Exit status"}) {
    EXPECT_NE(result.out.find(option), std::string::npos) << option;
  }
}

TEST_F(Simulate, IsBrokenOffWithinAFrameAndKeepsItsResults) {
  // A frame of it takes minutes, and reading it less than 3 s beside other work.
  const std::string scene = write("slow.yaml",
                                  "cloth: {columns: 300, rows: 300}\n"
                                  "simulation: {method: rk4, substeps: 10000}\n");
  const fs::path out = folder_ / "out";
  const std::string command = "timeout --preserve-status --signal=INT 3 " CLOTHSIM_SIMULATE " " +
                              scene + " --seconds 10 --output " + out.string() + " >" +
                              (folder_ / "stdout").string() + " 2>" + (folder_ / "stderr").string();
  const int status = std::system(command.c_str());
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 130);
  EXPECT_NE(read(folder_ / "stderr").find("simulate: interrupted in the frame after t = 0"),
            std::string::npos)
      << read(folder_ / "stderr");
  EXPECT_TRUE(fs::exists(out / "final.csv"));
  EXPECT_EQ(YAML::LoadFile((out / "report.yaml").string())["frames"].as<int>(), 0);
}

}  // namespace
}  // namespace clothsim::simulate_test
