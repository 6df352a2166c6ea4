#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>

#include "chart.h"
#include "clothsim/run/progress_bar.h"
#include "peers.h"

namespace clothsim::work_precision {
namespace {

struct Chart {
  const char* name;
  std::vector<Job> (*jobs)(const Options&);
};
constexpr Chart charts[] = {{"methods", methods_jobs},     {"winners", winners_jobs},
                            {"stability", stability_jobs}, {"strain_limit", strain_limit_jobs},
                            {"contact", contact_jobs},     {"threads", threads_jobs},
                            {"stretch", stretch_jobs}};

std::vector<std::string> chart_names() {
  std::vector<std::string> names;
  for (const Chart& chart : charts) names.emplace_back(chart.name);
  return names;
}

std::vector<std::string> scene_names() {
  std::vector<std::string> names;
  for (const bool quick : {false, true}) {
    for (const Trial& trial : trials(quick)) names.push_back(trial.name);
  }
  return names;
}

void measure(const Options& options) {
  std::filesystem::create_directories(options.output);
  std::vector<Job> jobs;
  for (const Chart& chart : charts) {
    if (!wanted(options.charts, chart.name)) continue;
    for (Job& job : chart.jobs(options)) jobs.push_back(std::move(job));
  }
  ProgressBar bar(static_cast<long long>(jobs.size()));
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    bar.update(static_cast<long long>(i));
    jobs[i]();
  }
}

}  // namespace

bool wanted(const std::vector<std::string>& list, const std::string& name) {
  return list.empty() || std::find(list.begin(), list.end(), name) != list.end();
}

}  // namespace clothsim::work_precision

int main(int argc, char** argv) {
  namespace wp = clothsim::work_precision;
  wp::Options options;
  CLI::App app(
      "Measures every method's error against its cost and writes CSV files, which "
      "plot_work_precision turns into charts.");
  app.add_option("--output", options.output, "Folder for the CSV files")->required();
  app.add_flag("--quick", options.quick, "Small and short: half a minute, tells little");
  app.add_option("--charts", options.charts, "Only these")
      ->check(CLI::IsMember(wp::chart_names()))
      ->delimiter(',');
  app.add_option("--scenes", options.scenes, "Only these of the chart of methods")
      ->check(CLI::IsMember(wp::scene_names()))
      ->delimiter(',');
  app.add_option("--methods", options.methods, "Only these, auto and peers among them")
      ->delimiter(',');
  try {
    app.parse(argc, argv);
    wp::measure(options);
    return 0;
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 1;
  } catch (const std::exception& error) {
    std::cerr << "work_precision: " << error.what() << '\n';
    return 1;
  }
}
