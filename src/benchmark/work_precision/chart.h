#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace clothsim::work_precision {

/// The user's options.
struct Options {
  std::filesystem::path output;
  bool quick = false;
  std::vector<std::string> charts;   // empty: all
  std::vector<std::string> scenes;   // of the chart of methods; empty: all
  std::vector<std::string> methods;  // empty: all
};

/// Is `name` in the list? An empty list contains all names.
bool wanted(const std::vector<std::string>& list, const std::string& name);

/// A chart is a list of jobs, done in order; the last one writes its CSV.
using Job = std::function<void()>;

/// Error against cost of every method on each scene, and the choice of `auto`: methods.csv,
/// references.csv, choices.csv.
std::vector<Job> methods_jobs(const Options&);

/// The cheapest method by stiffness and number of points: winners.csv.
std::vector<Job> winners_jobs(const Options&);

/// Where methods are stable, and their error: stability.csv.
std::vector<Job> stability_jobs(const Options&);

/// The strain limit's violation and rest shape against cost: strain_limit.csv.
std::vector<Job> strain_limit_jobs(const Options&);

/// Cost and undetected crossings of self contact by points and by surfaces: contact.csv.
std::vector<Job> contact_jobs(const Options&);

/// Times with one thread and with two: threads.csv.
std::vector<Job> threads_jobs(const Options&);

/// Stretch of the springs by method, for motion in which points cannot be compared: stretch.csv.
std::vector<Job> stretch_jobs(const Options&);

}  // namespace clothsim::work_precision
