#include "run_options.h"

#include <iostream>

namespace clothsim {

void add_assignments(CLI::App& app, const char* name, std::vector<std::string>& target,
                     const char* text) {
  app.add_option(name, target, text)->allow_extra_args(false)->type_name("KEY=VALUE");
}

CLI::Option* add_run_options(CLI::App& app, RunOptions& options, const std::string& files,
                             const std::string& frames) {
  app.add_option("scene", options.scene, "Scene file (YAML)")->required();
  app.add_option("--seconds", options.seconds,
                 "Time to simulate [s], rounded to whole frames; without it that of the motions");
  app.add_option(
      "--from", options.from,
      "Start from the state in a final.npz, or of the last frame in a frames.npz; motions "
      "begin then");
  add_assignments(app, "--set", options.overrides,
                  "Change a value of the scene: --set cloth.ks=500");
  CLI::Option* output = app.add_option("--output", options.output, "Folder for " + files);
  app.add_option("--every", options.every,
                 frames +
                     ", one each so much time [s], rounded to whole frames; those of an "
                     "earlier run are removed");
  return output;
}

int run_program(CLI::App& app, const char* program, int argc, char** argv,
                const std::function<ExitCode()>& run) {
  try {
    app.parse(argc, argv);
    return run();
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? done : bad_input;
  } catch (const std::exception& error) {
    std::cerr << program << ": " << error.what() << '\n';
    return bad_input;
  }
}

}  // namespace clothsim
