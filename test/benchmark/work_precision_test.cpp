// The benchmark of speed against accuracy as a user runs it, with short runs: its files, the trends
// that must show even so, and the charts from them.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "benchmark/work_precision/verdict.h"
#include "clothsim/dynamics/integrator.h"
#include "temporary_folder.h"

namespace clothsim::work_precision_test {
namespace {

namespace fs = std::filesystem;
using Row = std::map<std::string, std::string>;

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream text(line + ',');
  for (std::string cell; std::getline(text, cell, ',');) cells.push_back(cell);
  return cells;
}

/// Rows of a CSV file; every line must have a cell for each column.
std::vector<Row> read(const fs::path& path) {
  std::ifstream file(path);
  EXPECT_TRUE(file) << path;
  std::string line;
  std::getline(file, line);
  const std::vector<std::string> columns = split(line);
  std::vector<Row> rows;
  while (std::getline(file, line)) {
    const std::vector<std::string> cells = split(line);
    EXPECT_EQ(cells.size(), columns.size()) << path << ": " << line;
    if (cells.size() != columns.size()) continue;
    Row row;
    for (std::size_t i = 0; i < columns.size(); ++i) row[columns[i]] = cells[i];
    rows.push_back(row);
  }
  return rows;
}

double number(const Row& row, const std::string& column) {
  const std::string& text = row.at(column);
  return text.empty() ? std::numeric_limits<double>::quiet_NaN() : std::stod(text);
}

class WorkPrecision : public ::testing::Test {
 protected:
  /// All charts at once: the tests read the files of one run.
  static void SetUpTestSuite() {
    temporary_.emplace("work_precision");
    folder_ = temporary_->path();
    const std::string command = std::string(CLOTHSIM_WORK_PRECISION) + " --quick --output " +
                                folder_.string() + " > " + (folder_ / "out").string();
    ASSERT_EQ(std::system(command.c_str()), 0);
  }
  static void TearDownTestSuite() { temporary_.reset(); }

  static inline std::optional<test::TemporaryFolder> temporary_;
  static inline fs::path folder_;
};

TEST_F(WorkPrecision, ReferenceIsOfOrderTwoAndAgreesWithAnotherMethod) {
  const std::vector<Row> rows = read(folder_ / "references.csv");
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_NEAR(number(rows[0], "order"), 2, 0.1);
  EXPECT_GT(number(rows[0], "uncertainty"), 0);
  EXPECT_LT(number(rows[0], "uncertainty"), 1e-9);
  EXPECT_LT(number(rows[0], "cross_check"), 1e-9);
  EXPECT_GE(number(rows[0], "twin_growth"), 1);
}

TEST_F(WorkPrecision, SurfacesCrossNowhereInTheChartOfContact) {
  const std::vector<Row> rows = read(folder_ / "contact.csv");
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0].at("contact"), "points");
  EXPECT_EQ(rows[1].at("contact"), "surface");
  EXPECT_EQ(number(rows[1], "crossings"), 0);
  for (const Row& row : rows) EXPECT_GT(number(row, "cost_ms_per_s"), 0);
}

TEST_F(WorkPrecision, EveryMethodIsChartedAndVerletFallsWithOrderTwo) {
  std::set<std::string> seen;
  std::map<int, double> verlet;  // error by substeps
  for (const Row& row : read(folder_ / "methods.csv")) {
    seen.insert(row.at("method"));
    EXPECT_GT(number(row, "cost_ms_per_s"), 0);
    EXPECT_FALSE(row.at("used_method").empty());
    if (row.at("method") == VelocityVerlet::name) {
      verlet[std::stoi(row.at("substeps"))] = number(row, "position_error");
    }
    // Errors are numbers where there is one, and the largest is not below the mean.
    if (row.at("position_error").empty()) continue;
    EXPECT_GE(number(row, "position_max"), number(row, "position_error"));
    for (const char* column : {"velocity_error", "energy_error", "momentum_error", "centre_error",
                               "worst_stretch", "p99_stretch"}) {
      EXPECT_GE(number(row, column), 0) << column;
    }
    // With a method's own tolerances the solver error is far below that of the scheme.
    if (!row.at("solver_error").empty()) {
      EXPECT_LT(number(row, "solver_error"), 0.1 * number(row, "scheme_error"));
    }
  }
  for (const std::string& method : method_names()) EXPECT_EQ(seen.count(method), 1u) << method;
  EXPECT_EQ(seen.count("auto"), 1u);
  EXPECT_NEAR(std::log2(verlet.at(4) / verlet.at(8)), 2, 0.1);
  EXPECT_NEAR(std::log2(verlet.at(8) / verlet.at(16)), 2, 0.1);
}

TEST_F(WorkPrecision, ToldWhatAutoForetoldAndPassedOver) {
  // On a cloth of 64 points a frame costs microseconds: the ranking of the methods means nothing.
  const std::vector<Row> rows = read(folder_ / "choices.csv");
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_EQ(rows[0].at("method"), "verlet");
  EXPECT_GT(number(rows[0], "position_error"), 0);
  EXPECT_GT(number(rows[0], "predicted_error"), 0);
  if (rows[0].at("passed_over").empty()) return;
  EXPECT_NE(rows[0].at("passed_over"), "verlet");
  EXPECT_LE(number(rows[0], "its_cost_ms_per_s"), number(rows[0], "cost_ms_per_s"));
}

TEST(Verdict, TheBestPassedOverIsTheMostExactOfTheOthersThatCostNoMore) {
  using work_precision::Contender;
  const Contender chosen{"verlet", 10, 1e-4};
  const std::vector<Contender> runs = {{"verlet", 9, 1e-9},  // the same method
                                       {"rk4", 11, 1e-9},    // dearer
                                       {"xpbd", 3, 1e-2},    // cheaper
                                       {"xpbd", 10, 1e-3},   // as dear
                                       {"bdf2", 8, 2e-3}};
  const auto best = work_precision::best_passed_over(chosen, runs);
  ASSERT_TRUE(best);
  EXPECT_EQ(best->method, "xpbd");
  EXPECT_EQ(best->error, 1e-3);
  EXPECT_FALSE(work_precision::best_passed_over({"verlet", 2, 1e-4}, runs));
}

TEST_F(WorkPrecision, FailuresAreRecordedWhereTheoryHasThem) {
  // Explicit methods beyond their limit, with a margin for a step that only just fails.
  int failed = 0;
  for (const Row& row : read(folder_ / "stability.csv")) {
    const double ratio = number(row, "step_s") / number(row, "limit_s");
    if (ratio > 1.5) {
      EXPECT_EQ(row.at("status"), "failed") << row.at("method") << ' ' << row.at("step_s");
      EXPECT_EQ(row.at("position_error"), "");
      ++failed;
    } else if (ratio > 0 && ratio < 0.8) {
      EXPECT_EQ(row.at("status"), "done") << row.at("method") << ' ' << row.at("step_s");
    }
  }
  EXPECT_GT(failed, 10);
}

TEST_F(WorkPrecision, StrainLimitBeatsTheClassicOne) {
  std::map<std::string, Row> rows;
  for (const Row& row : read(folder_ / "strain_limit.csv")) rows[row.at("solver")] = row;
  const Row& ours = rows.at("auto");
  EXPECT_LT(number(ours, "worst_violation"), 1.01 * number(ours, "tolerance"));
  EXPECT_LT(number(ours, "rest_speed"), 1e-4);
  EXPECT_LT(number(ours, "rest_error_max"), 1e-3);
  EXPECT_LT(number(ours, "rest_error_max"), number(rows.at("classic"), "rest_error_max"));
}

TEST_F(WorkPrecision, TwoThreadsAreTimedBesideOne) {
  const std::vector<Row> rows = read(folder_ / "threads.csv");
  ASSERT_EQ(rows.size(), 2u);
  for (int i = 0; i < 2; ++i) {
    const Row& row = rows[static_cast<std::size_t>(i)];
    EXPECT_EQ(number(row, "threads"), i + 1);
    EXPECT_GT(number(row, "wall_ms_per_s"), 0);
    EXPECT_GT(number(row, "cpu_ms_per_s"), 0);
  }
}

TEST_F(WorkPrecision, StretchOfEveryMethodAddsUpToAllSprings) {
  std::map<std::string, double> sum, mean;
  for (const Row& row : read(folder_ / "stretch.csv")) {
    EXPECT_EQ(row.at("status"), "done");
    sum[row.at("method")] += number(row, "share");
    mean[row.at("method")] += number(row, "share") * number(row, "stretch");
  }
  for (const std::string& method : method_names()) EXPECT_EQ(sum.count(method), 1u) << method;
  for (const auto& [method, all] : sum) EXPECT_NEAR(all, 1, 1e-9) << method;
  EXPECT_NEAR(mean.at("twin"), mean.at("reference"), 1e-3);
  EXPECT_NE(mean.at("xpbd"), mean.at("reference"));
}

TEST_F(WorkPrecision, ScriptDrawsEveryChart) {
  const std::string command = std::string("MPLCONFIGDIR=") + folder_.string() + ' ' +
                              CLOTHSIM_PLOT_WORK_PRECISION + ' ' + folder_.string() + " > " +
                              (folder_ / "out").string();
  ASSERT_EQ(std::system(command.c_str()), 0);
  for (const char* name : {"work_precision", "solver_error", "winners", "stability", "strain_limit",
                           "contact", "threads", "stretch"}) {
    const fs::path png = folder_ / (std::string(name) + ".png");
    ASSERT_TRUE(fs::exists(png)) << name;
    EXPECT_GT(fs::file_size(png), 10'000u) << name;
  }
}

}  // namespace
}  // namespace clothsim::work_precision_test
