#include <memory>
#include <string>

#include "commands.hpp"
#include "describe.hpp"
#include "describe_model.hpp"
#include "pipeline/embedded_model.hpp"
#include "recording/error.hpp"

namespace egofocus::app {

void add_info(CLI::App& program) {
  struct Arguments {
    std::string path;
    bool json = false;
  };
  CLI::App* command = program.add_subcommand("info", "tell what a file or a recording folder is");
  auto arguments = std::make_shared<Arguments>();
  command->add_option("FILE", arguments->path, "file or recording folder (default: the embedded model)");
  command->add_flag("--json", arguments->json, "one line of JSON");
  command->footer(
      "Examples:\n  egofocus info fixtures/planes\n  egofocus info fixtures/planes/vehicle.dbc --json");
  command->callback([arguments] {
    if (arguments->path.empty()) {
      if (embedded_model().empty())
        throw recording::Error(recording::ExitCode::kUsage, "info",
                               "this build embeds no model: FILE is required.");
      const Json model = describe_model(embedded_model(), "the embedded model");
      std::puts((arguments->json ? model.json() : model.text()).c_str());
      return;
    }
    std::error_code ignored;
    const bool is_folder = std::filesystem::is_directory(arguments->path, ignored);
    const Json facts = is_folder ? describe_recording(arguments->path) : describe_file(arguments->path);
    std::puts((arguments->json ? facts.json() : facts.text()).c_str());
  });
}

}  // namespace egofocus::app
