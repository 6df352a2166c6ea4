#pragma once

#include <CLI/CLI.hpp>
#include <functional>

#include "run.h"

namespace clothsim {

/// The options of all programs that run a scene; `files` and `frames` name what --output and
/// --every write. Returns --output.
CLI::Option* add_run_options(CLI::App&, RunOptions&, const std::string& files,
                             const std::string& frames);

/// An option that takes one KEY=VALUE each time it is given.
void add_assignments(CLI::App&, const char* name, std::vector<std::string>& target,
                     const char* text);

/// Parses, runs and turns what is thrown into a line on standard error and an exit status.
int run_program(CLI::App&, const char* program, int argc, char** argv,
                const std::function<ExitCode()>& run);

}  // namespace clothsim
