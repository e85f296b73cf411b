#include <chrono>
#include <cstdio>
#include <thread>

#include "citysim/command_line.hpp"
#include "citysim/commands.hpp"
#include "citysim/sample_cache.hpp"
#include "recording/json.hpp"
#include "recording/progress.hpp"
#include "recording/text_file.hpp"

namespace egofocus::citysim {
namespace {

constexpr const char* kExamples = R"(
Samples are kept in the folder in shards of 64; shards that are there are not made again, so an interrupted run
goes on, and a larger --count adds to a smaller one. With --stdout the shards are also written to the standard
output, one after the other, as a trainer reads them from a pipe. The layout is in tools/citysim/README.md.

Examples:
  citysim samples --out cache --count 20000 --seed 1
  citysim samples --out cache --count 512 --families town1 room room desk
  citysim samples --out cache --count 20000 --seed 1 --stdout | my_trainer)";

void copy_to_stdout(const SampleOptions& options, const std::string& folder) {
  const int shards = (options.count + kShardSamples - 1) / kShardSamples;
  for (int shard = 0; shard < shards; ++shard) {
    const std::string bytes = recording::read_text_file(shard_path(folder, shard));
    if (std::fwrite(bytes.data(), 1, bytes.size(), stdout) != bytes.size()) {
      throw recording::Error(recording::ExitCode::kFile, "standard output", "does not take more samples.");
    }
  }
}

}  // namespace

int run_samples(std::span<const std::string> arguments) {
  // town4 and town5_night are kept out: what networks are judged on must be unseen.
  std::vector<std::string> names = {"town1", "town2_night", "town3", "room",
                                    "room",  "desk",        "desk",  "corridor"};
  std::string out;
  std::string size = "346x260";
  bool json = false;
  bool to_stdout = false;
  SampleOptions options;
  options.threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  CLI::App program("Training samples: events of a window, velocities, camera, exact inverse depth.",
                   "citysim samples");
  program.footer(about_families() + kExamples);
  program.add_option("--out", out, "folder of the cache")->required();
  program.add_option("--count", options.count, "samples")
      ->check(CLI::Range(1, 10000000))
      ->capture_default_str();
  program.add_option("--seed", options.seed, "everything is drawn from it")->capture_default_str();
  program.add_option("--families", names, "drawn from evenly; a name given twice counts twice")
      ->capture_default_str();
  program.add_option("--size", size, "the sensor's pixels")->capture_default_str();
  program.add_option("--threads", options.threads, "the bytes do not depend on it")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  program.add_flag("--stdout", to_stdout, "write the shards to the standard output, too");
  program.add_flag("--json", json, "print facts as JSON (on stderr with --stdout)");
  int code = 0;
  if (!parse(program, arguments, code)) return code;

  for (const std::string& name : names) options.families.push_back(parse_family(name));
  parse_size(size, options.width_px, options.height_px);
  const auto start = std::chrono::steady_clock::now();
  int made = 0;
  {
    recording::Progress progress("samples");
    options.progress = [&progress](int done, int all) {
      progress.show(static_cast<std::size_t>(done), static_cast<std::size_t>(all));
    };
    made = fill_sample_cache(options, out);
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  recording::Json facts;
  facts.add("folder", out)
      .add("shards_made", made)
      .add("samples_made", made * kShardSamples)
      .add("seconds", seconds);
  if (made > 0) facts.add("samples_per_s_and_thread", made * kShardSamples / seconds / options.threads);
  if (to_stdout) copy_to_stdout(options, out);
  std::fprintf(to_stdout ? stderr : stdout, "%s\n", (json ? facts.json() : facts.text()).c_str());
  return static_cast<int>(recording::ExitCode::kOk);
}

}  // namespace egofocus::citysim
