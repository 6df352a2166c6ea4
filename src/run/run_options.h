#pragma once

#include <CLI/CLI.hpp>
#include <functional>

#include "run.h"

namespace clothsim {

/// Adds the options of all programs that run a scene; `files` and `frames` describe the files of
/// --output and --every. Returns --output.
CLI::Option* add_run_options(CLI::App&, RunOptions&, const std::string& files,
                             const std::string& frames);

/// Adds an option that takes one KEY=VALUE each time it is given.
void add_assignments(CLI::App&, const char* name, std::vector<std::string>& target,
                     const char* text);

/// Parses, runs and turns exceptions into a line on standard error and an exit code.
int run_program(CLI::App&, const char* program, int argc, char** argv,
                const std::function<ExitCode()>& run);

}  // namespace clothsim
