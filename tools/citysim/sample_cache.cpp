#include "citysim/sample_cache.hpp"

#include <cstdio>
#include <mutex>

#include "citysim/sample.hpp"
#include "recording/error.hpp"
#include "recording/text_file.hpp"

namespace egofocus::citysim {
namespace {

namespace fs = std::filesystem;
using recording::Error;
using recording::ExitCode;

constexpr char kMagic[8] = {'E', 'G', 'S', 'H', 'A', 'R', 'D', '2'};
constexpr double kWorld_s = 12;
constexpr int kLibraryShards = 8;  // that share a stock of surfaces: making one takes as long as ten samples

std::string arguments_text(const SampleOptions& options) {
  std::string text = "citysim samples\nseed " + std::to_string(options.seed) + "\nsize " +
                     std::to_string(options.width_px) + "x" + std::to_string(options.height_px) +
                     "\nfamilies";
  for (const Family family : options.families) text += " " + std::string(name_of(family));
  return text + "\n";
}

std::uint64_t number_seed(const SampleOptions& options, int number) {
  return mix_bits(mix_bits(options.seed) + static_cast<std::uint64_t>(number));
}

/// The stock of surfaces that neighbouring shards share. Those that wait for one need it, too, so one lock
/// does.
class Libraries {
 public:
  explicit Libraries(const SampleOptions& options) : options_(options) {}

  std::shared_ptr<const TextureLibrary> of_shard(int shard) {
    const int number = shard / kLibraryShards;
    const std::lock_guard lock(mutex_);
    if (!library_ || number != number_) {
      number_ = number;
      library_ = std::make_shared<const TextureLibrary>(mix_bits(number_seed(options_, number) ^ 0x7e87));
    }
    return library_;
  }

 private:
  const SampleOptions& options_;
  std::mutex mutex_;
  int number_ = -1;
  std::shared_ptr<const TextureLibrary> library_;
};

/// One thread makes a shard alone, so its bytes depend on nothing but its number and the arguments.
std::vector<std::byte> make_shard(const SampleOptions& options, int shard,
                                  const std::shared_ptr<const TextureLibrary>& library) {
  std::vector<std::byte> bytes;
  for (const char letter : kMagic) bytes.push_back(static_cast<std::byte>(letter));
  const std::uint64_t seed = number_seed(options, shard);
  Workers alone(1);
  for (int w = 0; w < kShardSamples / kWorldSamples; ++w) {
    const std::uint64_t world_seed = mix_bits(seed ^ (static_cast<std::uint64_t>(w) + 1));
    Random random(world_seed, "family");
    const Family family = options.families[random.below(static_cast<std::uint32_t>(options.families.size()))];
    const World world = make_world(family,
                                   {.width_px = options.width_px,
                                    .height_px = options.height_px,
                                    .duration_s = kWorld_s,
                                    .clean_sensor = false,
                                    .library = library},
                                   world_seed);
    for (const Sample& sample : draw_samples(world, world_seed, kWorld_s, kWorldSamples, alone)) {
      const std::vector<std::byte> record = sample_bytes(sample);
      for (std::size_t i = 0; i < 4; ++i)
        bytes.push_back(static_cast<std::byte>((record.size() >> (8 * i)) & 0xff));
      bytes.insert(bytes.end(), record.begin(), record.end());
    }
  }
  return bytes;
}

}  // namespace

fs::path shard_path(const fs::path& folder, int shard) {
  char name[32];
  std::snprintf(name, sizeof name, "shard_%06d.egs", shard);
  return folder / name;
}

int fill_sample_cache(const SampleOptions& options, const fs::path& folder) {
  std::error_code failure;
  fs::create_directories(folder, failure);
  if (failure) throw Error(ExitCode::kFile, folder.string(), "cannot be made (" + failure.message() + ").");
  const fs::path about = folder / "samples.txt";
  const std::string arguments = arguments_text(options);
  if (!fs::exists(about)) {
    recording::write_text_file(about, arguments);
  } else if (recording::read_text_file(about) != arguments) {
    throw Error(ExitCode::kUsage, folder.string(),
                "holds samples of other arguments: see samples.txt there. Choose another folder.");
  }
  const int shards = (options.count + kShardSamples - 1) / kShardSamples;
  std::vector<int> missing;
  for (int shard = 0; shard < shards; ++shard) {
    if (!fs::exists(shard_path(folder, shard))) missing.push_back(shard);
  }
  std::mutex mutex;
  int done = shards - static_cast<int>(missing.size());
  Libraries libraries(options);
  Workers workers(options.threads);
  workers.for_each(static_cast<int>(missing.size()), [&](int i) {
    const int shard = missing[static_cast<std::size_t>(i)];
    const std::vector<std::byte> bytes = make_shard(options, shard, libraries.of_shard(shard));
    recording::write_text_file(shard_path(folder, shard),
                               {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
    const std::lock_guard lock(mutex);
    ++done;
    if (options.progress) options.progress(done, shards);
  });
  return static_cast<int>(missing.size());
}

}  // namespace egofocus::citysim
