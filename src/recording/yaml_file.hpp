// A YAML file as a flat list: "cam0.intrinsics" -> its scalars in order, nested sequences included.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace egofocus::recording {

class YamlFile {
 public:
  /// Throws Error: kFile (missing, or this build has no yaml-cpp), kBadFile (no YAML, or far too large).
  explicit YamlFile(std::filesystem::path path);

  [[nodiscard]] bool has(const std::string& key) const { return scalars_.count(key) > 0; }

  /// One scalar. Throws Error (kBadFile) when it is missing or a list.
  [[nodiscard]] const std::string& text(const std::string& key) const;

  /// Numbers. Throws Error (kBadFile) when there are fewer or more, or one is no finite number.
  [[nodiscard]] std::vector<double> numbers(const std::string& key, std::size_t fewest,
                                            std::size_t most) const;
  [[nodiscard]] std::vector<double> numbers(const std::string& key, std::size_t count) const {
    return numbers(key, count, count);
  }

  [[nodiscard]] std::string name() const { return path_.string(); }

 private:
  [[nodiscard]] const std::vector<std::string>& at(const std::string& key) const;

  std::filesystem::path path_;
  std::map<std::string, std::vector<std::string>> scalars_;
};

}  // namespace egofocus::recording
