#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace clothsim::work_precision {

/// What the user asked for.
struct Options {
  std::filesystem::path output;
  bool quick = false;
  std::vector<std::string> charts;   // empty: all
  std::vector<std::string> scenes;   // of the chart of methods; empty: all
  std::vector<std::string> methods;  // empty: all
};

/// Is `name` in the list? An empty list has all.
bool wanted(const std::vector<std::string>& list, const std::string& name);

/// A chart is a row of jobs, done in order; the last one writes its CSV.
using Job = std::function<void()>;

/// Error against cost of every method on each scene, and what `auto` chose: methods.csv,
/// references.csv, choices.csv.
std::vector<Job> methods_jobs(const Options&);

/// The cheapest method by stiffness and number of points: winners.csv.
std::vector<Job> winners_jobs(const Options&);

/// Where methods are stable, and how far off: stability.csv.
std::vector<Job> stability_jobs(const Options&);

/// The strain limit's violation and rest shape against cost: strain_limit.csv.
std::vector<Job> strain_limit_jobs(const Options&);

/// What self contact by points and by surfaces costs and misses: contact.csv.
std::vector<Job> contact_jobs(const Options&);

/// What one thread and two take: threads.csv.
std::vector<Job> threads_jobs(const Options&);

/// How stretched the springs of each method are where points can no longer be compared:
/// stretch.csv.
std::vector<Job> stretch_jobs(const Options&);

}  // namespace clothsim::work_precision
