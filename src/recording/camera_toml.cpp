#include "recording/camera_toml.hpp"

#include <toml++/toml.h>

#include <limits>
#include <span>

#include "recording/camera_schema.hpp"
#include "recording/error.hpp"
#include "recording/text_file.hpp"

namespace egofocus::recording {
namespace {

[[noreturn]] void fail(const std::string& name, const toml::source_region& at, const std::string& what) {
  throw Error(ExitCode::kConfiguration, name + ":" + std::to_string(at.begin.line), what);
}

template <typename Enum, std::size_t N>
std::string listed(const Names<Enum, N>& names) {
  std::string text;
  for (const auto& [name, value] : names) text += (text.empty() ? "\"" : ", \"") + std::string(name) + "\"";
  return text;
}

/// One table while it is read. Remembers the keys that the schema knows, so that the others can be reported.
class SectionReader {
 public:
  SectionReader(const toml::table& table, std::string title, const std::string& file)
      : table_(table), title_(std::move(title)), file_(file) {}

  template <typename T>
  void required(const char* key, T& value) {
    need(key);
    optional(key, value);
  }

  void need(const char* key) const {
    if (!table_.contains(key)) {
      fail(file_, table_.source(),
           title_ + " lacks the key `" + key + "`. Add it; docs/formats.md has an example.");
    }
  }

  template <typename T>
  void optional(const char* key, T& value) {
    if (const toml::node* node = find(key)) read(*node, key, value);
  }

  template <std::size_t N>
  void optional(const char* key, double (&values)[N]) {
    const toml::node* node = find(key);
    if (!node) return;
    const toml::array& array = array_of(*node, key, N);
    for (std::size_t i = 0; i < N; ++i) values[i] = 0;
    for (std::size_t i = 0; i < array.size(); ++i) read(array[i], key, values[i]);
  }

  template <typename Enum, std::size_t N>
  void choice(const char* key, Enum& value, const Names<Enum, N>& names) {
    if (const toml::node* node = find(key)) value = chosen(*node, key, names);
  }

  template <std::size_t N>
  void axes(const char* key, AxisMap& value, const Names<std::int8_t, N>& names) {
    const toml::node* node = find(key);
    if (!node) return;
    const toml::array& array = array_of(*node, key, 3);
    for (std::size_t i = 0; i < array.size(); ++i) value.from[i] = chosen(array[i], key, names);
  }

  /// A required text with a longest length.
  template <std::size_t N>
  void name(const char* key, char (&value)[N]) {
    std::string text;
    required(key, text);
    if (text.size() >= N)
      wrong(*table_.get(key), key, "must have at most " + std::to_string(N - 1) + " characters");
    text.copy(value, text.size());
    value[text.size()] = '\0';
  }

  /// A required name that the decoder knows.
  template <typename Enum>
  void required_named(const char* key, Enum& value, bool (*value_of)(std::string_view, Enum&) noexcept,
                      const char* (*name_of)(Enum) noexcept, std::size_t count) {
    need(key);
    named(key, value, value_of, name_of, count);
  }

  template <typename Enum>
  void named(const char* key, Enum& value, bool (*value_of)(std::string_view, Enum&) noexcept,
             const char* (*name_of)(Enum) noexcept, std::size_t count) {
    const toml::node* node = find(key);
    if (!node) return;
    if (node->is_string() && value_of(node->as_string()->get(), value)) return;
    std::string list;
    for (std::size_t i = 0; i < count; ++i)
      list += std::string(i > 0 ? ", " : "") + name_of(static_cast<Enum>(i));
    wrong(*node, key, "must be one of " + list);
  }

  /// No key: no limit.
  void limit(const char* key, std::uint64_t& value) {
    const toml::node* node = find(key);
    if (!node) return;
    std::int64_t number = 0;
    read(*node, key, number);
    if (number < 0) wrong(*node, key, "must not be negative");
    value = static_cast<std::uint64_t>(number);
  }

  template <typename T, std::size_t N>
  void tables(const char* key, T (&values)[N], std::size_t& count) {
    const toml::node* node = find(key);
    if (!node) return;
    const std::string title = "[[" + title_.substr(1, title_.size() - 2) + "." + key + "]]";
    const toml::array* array = node->as_array();
    if (!array || !array->is_homogeneous<toml::table>())
      wrong(*node, key, "must be a list of tables " + title);
    if (array->size() > N) wrong(*node, key, "must have at most " + std::to_string(N) + " entries");
    for (const toml::node& entry : *array) {
      SectionReader reader(*entry.as_table(), title, file_);
      describe(reader, values[count++]);
      reader.finish();
    }
  }

  /// Call after the last key.
  void finish() const {
    for (const auto& [key, node] : table_) {
      bool is_known = false;
      std::string list;
      for (const char* name : known_) {
        is_known = is_known || key.str() == name;
        list += (list.empty() ? "" : ", ") + std::string(name);
      }
      if (!is_known) {
        fail(file_, key.source(),
             title_ + " has no key `" + std::string(key.str()) + "`. Known keys: " + list + ".");
      }
    }
  }

 private:
  const toml::node* find(const char* key) {
    known_.push_back(key);
    return table_.get(key);
  }

  [[noreturn]] void wrong(const toml::node& node, const char* key, const std::string& what) const {
    fail(file_, node.source(), title_ + " `" + key + "` " + what + ".");
  }

  /// Fewer numbers than fit are allowed for coefficients alone: the missing ones are 0.
  const toml::array& array_of(const toml::node& node, const char* key, std::size_t count) const {
    const toml::array* array = node.as_array();
    const bool may_be_short = std::string_view(key) == "coefficients";
    if (!array || array->size() > count || (!may_be_short && array->size() != count)) {
      wrong(node, key,
            "must be a list of " + std::string(may_be_short ? "up to " : "") + std::to_string(count) +
                " values");
    }
    return *array;
  }

  template <typename Enum, std::size_t N>
  Enum chosen(const toml::node& node, const char* key, const Names<Enum, N>& names) const {
    const auto text = node.value<std::string>();
    for (const auto& [name, value] : names) {
      if (text == name) return value;
    }
    wrong(node, key, "must be one of " + listed(names));
  }

  void read(const toml::node& node, const char* key, double& value) const {
    if (!node.is_number()) wrong(node, key, "must be a number");
    value =
        node.is_integer() ? static_cast<double>(node.as_integer()->get()) : node.as_floating_point()->get();
  }

  void read(const toml::node& node, const char* key, bool& value) const {
    if (!node.is_boolean()) wrong(node, key, "must be true or false");
    value = node.as_boolean()->get();
  }

  template <typename Integer>
  requires std::is_integral_v<Integer>
  void read(const toml::node& node, const char* key, Integer& value) const {
    const toml::value<std::int64_t>* number = node.as_integer();
    if (!number) wrong(node, key, "must be an integer");
    constexpr std::int64_t kMin = std::numeric_limits<Integer>::min();
    constexpr auto kMax = static_cast<std::int64_t>(std::numeric_limits<Integer>::max());
    if (number->get() < kMin || number->get() > kMax) {
      wrong(node, key, "must lie in " + std::to_string(kMin) + " .. " + std::to_string(kMax));
    }
    value = static_cast<Integer>(number->get());
  }

  void read(const toml::node& node, const char* key, std::string& value) const {
    if (!node.is_string()) wrong(node, key, "must be a text in quotes");
    value = node.as_string()->get();
  }

  const toml::table& table_;
  std::string title_;
  const std::string& file_;
  std::vector<const char*> known_;
};

/// The whole file while it is read.
class FileReader {
 public:
  FileReader(const toml::table& root, const std::string& file) : root_(root), file_(file) {}

  template <typename T>
  void section(const char* name, T& value) {
    known_.push_back(name);
    const toml::node* node = root_.get(name);
    if (!node) return;
    if (!node->is_table())
      fail(file_, node->source(), "`" + std::string(name) + "` must be a section [" + name + "].");
    SectionReader reader(*node->as_table(), "[" + std::string(name) + "]", file_);
    describe(reader, value);
    reader.finish();
  }

  void finish() const {
    for (const auto& [key, node] : root_) {
      bool is_known = false;
      std::string list;
      for (const char* name : known_) {
        is_known = is_known || key.str() == name;
        list += (list.empty() ? "[" : ", [") + std::string(name) + "]";
      }
      if (!is_known) {
        fail(file_, key.source(),
             "unknown section or key `" + std::string(key.str()) + "`. Known sections: " + list + ".");
      }
    }
    if (!root_.contains("camera")) {
      throw Error(ExitCode::kConfiguration, file_,
                  "lacks the section [camera]. Add it; docs/formats.md has an example.");
    }
  }

 private:
  const toml::table& root_;
  const std::string& file_;
  std::vector<const char*> known_;
};

}  // namespace

CameraFile parse_camera_toml(std::string_view text, const std::string& name) {
  CameraFile file;
  try {
    const toml::table root = toml::parse(text, name);
    FileReader reader(root, name);
    describe_file(reader, file);
    reader.finish();
  } catch (const toml::parse_error& error) {
    fail(name, error.source(), "is no valid TOML: " + std::string(error.description()));
  }
  return file;
}

CameraFile read_camera_toml(const std::filesystem::path& path) {
  return parse_camera_toml(read_text_file(path), path.string());
}

}  // namespace egofocus::recording
