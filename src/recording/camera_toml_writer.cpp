#include <string>

#include "recording/camera_schema.hpp"
#include "recording/number_text.hpp"
#include "recording/text_file.hpp"

namespace egofocus::recording {
namespace {

/// TOML keeps integers and floating-point numbers apart: 2 becomes 2.0.
template <typename Number>
std::string toml_number(Number value) {
  std::string text = number_text(value);
  if (std::is_floating_point_v<Number> && text.find_first_of(".en") == std::string::npos) text += ".0";
  return text;
}

std::string in_quotes(std::string_view value) {
  std::string text = "\"";
  for (const char c : value) {
    if (c == '"' || c == '\\') text += '\\';
    text += c;
  }
  return text + "\"";
}

class SectionWriter {
 public:
  SectionWriter(std::string& out, const char* section) : out_(out), section_(section) {}

  template <typename T>
  void required(const char* key, const T& value) {
    optional(key, value);
  }

  template <typename T>
  void optional(const char* key, const T& value) {
    if constexpr (std::is_same_v<T, bool>) {
      line(key, value ? "true" : "false");
    } else if constexpr (std::is_arithmetic_v<T>) {
      line(key, toml_number(value));
    } else {
      line(key, in_quotes(value));
    }
  }

  template <std::size_t N>
  void optional(const char* key, const double (&values)[N]) {
    std::string list;
    for (const double value : values) list += (list.empty() ? "[" : ", ") + toml_number(value);
    line(key, list + "]");
  }

  template <typename Enum, std::size_t N>
  void choice(const char* key, Enum value, const Names<Enum, N>& names) {
    line(key, in_quotes(name_of(value, names)));
  }

  template <std::size_t N>
  void axes(const char* key, const AxisMap& value, const Names<std::int8_t, N>& names) {
    std::string list;
    for (const std::int8_t axis : value.from)
      list += (list.empty() ? "[" : ", ") + in_quotes(name_of(axis, names));
    line(key, list + "]");
  }

  void name(const char* key, const char* value) { line(key, in_quotes(value)); }

  template <typename Enum>
  void named(const char* key, Enum value, bool (*)(std::string_view, Enum&) noexcept,
             const char* (*name_of_value)(Enum) noexcept, std::size_t) {
    line(key, in_quotes(name_of_value(value)));
  }

  template <typename... Arguments>
  void required_named(Arguments... arguments) {
    named(arguments...);
  }

  void limit(const char* key, std::uint64_t value) {
    if (value <= static_cast<std::uint64_t>(INT64_MAX)) line(key, toml_number(value));
  }

  template <typename T, std::size_t N>
  void tables(const char* key, T (&values)[N], std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
      out_ += "\n[[" + std::string(section_) + "." + key + "]]\n";
      describe(*this, values[i]);
    }
  }

 private:
  template <typename Enum, std::size_t N>
  static std::string_view name_of(Enum wanted, const Names<Enum, N>& names) {
    for (const auto& [name, value] : names) {
      if (value == wanted) return name;
    }
    return names[0].first;
  }

  void line(const char* key, const std::string& value) { out_ += std::string(key) + " = " + value + "\n"; }

  std::string& out_;
  const char* section_;
};

class FileWriter {
 public:
  template <typename T>
  void section(const char* name, T& value) {
    if (!present(value)) return;
    text += (text.empty() ? "[" : "\n[") + std::string(name) + "]\n";
    SectionWriter writer(text, name);
    describe(writer, value);
  }

  std::string text;

 private:
  template <typename T>
  static bool present(const T&) {
    return true;
  }
  static bool present(const Intrinsics& grid) { return grid.width_px != 0; }
  static bool present(const CanSetup& can) { return can.motion.signal_count > 0; }
  static bool present(const UsbSetup& usb) { return usb.is_given; }
  static bool present(const V4l2Setup& v4l2) { return v4l2.is_given; }
};

}  // namespace

std::string camera_toml_text(const CameraFile& file) {
  CameraFile copy = file;  // the schema takes mutable references, for the reader's sake
  FileWriter writer;
  describe_file(writer, copy);
  return writer.text;
}

void write_camera_toml(const std::filesystem::path& path, const CameraFile& file) {
  write_text_file(path, camera_toml_text(file));
}

}  // namespace egofocus::recording
