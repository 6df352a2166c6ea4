#include "run_options.h"

int main(int argc, char** argv) {
  clothsim::RunOptions options;
  CLI::App app("Runs a cloth scene as fast as it goes, without ROS, and prints a report.");
  CLI::Option* output = clothsim::add_run_options(
      app, options, "final.csv, final.npz, report.yaml, frames.npz and frames/",
      "Also write frames.npz, and frames/NNNNNN.ply");
  app.get_option("--every")->needs(output);
  app.footer(
      "Exit status: 0 done, 1 bad input, 2 diverged, 130 interrupted (files hold the last "
      "good frame). film does the same and draws pictures or a video.");
  return clothsim::run_program(app, "simulate", argc, argv,
                               [&] { return clothsim::run("simulate", options); });
}
