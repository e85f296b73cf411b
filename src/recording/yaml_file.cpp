#include "recording/yaml_file.hpp"

#include <charconv>
#include <cmath>
#include <utility>

#include "recording/error.hpp"
#include "recording/text_file.hpp"

#ifdef EGOFOCUS_HAVE_YAML
#include <yaml-cpp/yaml.h>
#endif

namespace egofocus::recording {
namespace {

#ifdef EGOFOCUS_HAVE_YAML

constexpr std::uintmax_t kLargestBytes = 1u << 20;
constexpr std::size_t kMostScalars = 100000;  // aliases can make a small file very large
constexpr int kDeepest = 16;

struct Flattener {
  std::map<std::string, std::vector<std::string>>& scalars;
  std::size_t count = 0;

  void add(const YAML::Node& node, const std::string& key, int depth) {
    if (depth > kDeepest || ++count > kMostScalars)
      throw YAML::Exception(node.Mark(), "too deep or too large");
    if (node.IsMap()) {
      for (const auto& entry : node) {
        const std::string name = entry.first.as<std::string>();
        add(entry.second, key.empty() ? name : key + "." + name, depth + 1);
      }
    } else if (node.IsSequence()) {
      (void)scalars[key];
      for (const auto& entry : node) add(entry, key, depth + 1);
    } else if (node.IsScalar()) {
      scalars[key].push_back(node.Scalar());
    }
  }
};

#endif

}  // namespace

YamlFile::YamlFile(std::filesystem::path path) : path_(std::move(path)) {
#ifdef EGOFOCUS_HAVE_YAML
  const std::string text = read_text_file(path_);
  if (text.size() > kLargestBytes) throw Error(ExitCode::kBadFile, name(), "is too large for a calibration.");
  try {
    Flattener{scalars_}.add(YAML::Load(text), "", 0);
  } catch (const YAML::Exception& error) {
    throw Error(ExitCode::kBadFile, name() + ":" + std::to_string(error.mark.line + 1),
                "is no good YAML: " + error.msg + ".");
  }
#else
  throw Error(ExitCode::kFile, name(),
              "YAML needs yaml-cpp, and this build has none. Debian: apt-get install libyaml-cpp-dev, then "
              "build again.");
#endif
}

const std::vector<std::string>& YamlFile::at(const std::string& key) const {
  const auto found = scalars_.find(key);
  if (found == scalars_.end())
    throw Error(ExitCode::kBadFile, name(), "has no `" + key + "`. Is it the right calibration?");
  return found->second;
}

const std::string& YamlFile::text(const std::string& key) const {
  const std::vector<std::string>& values = at(key);
  if (values.size() != 1) throw Error(ExitCode::kBadFile, name(), "`" + key + "` must be one value.");
  return values[0];
}

std::vector<double> YamlFile::numbers(const std::string& key, std::size_t fewest, std::size_t most) const {
  const std::vector<std::string>& values = at(key);
  if (values.size() < fewest || values.size() > most) {
    throw Error(ExitCode::kBadFile, name(),
                "`" + key + "` has " + std::to_string(values.size()) + " values; " + std::to_string(fewest) +
                    (most > fewest ? " to " + std::to_string(most) : "") + " are needed.");
  }
  std::vector<double> numbers;
  for (const std::string& value : values) {
    double parsed = 0;
    const char* const end = value.data() + value.size();
    const auto [stop, problem] = std::from_chars(value.data(), end, parsed);
    if (problem != std::errc() || stop != end || !std::isfinite(parsed)) {
      throw Error(ExitCode::kBadFile, name(), "`" + key + "` holds `" + value + "`, which is no number.");
    }
    numbers.push_back(parsed);
  }
  return numbers;
}

}  // namespace egofocus::recording
