#include "hal/raw_header.hpp"

#include <string_view>

namespace egofocus {
namespace {

constexpr std::size_t kMaxLineBytes = 1024;
constexpr std::int64_t kMaxLines = 256;
constexpr std::uint32_t kMaxSidePx = 2048;  // 11 address bits

// What the lines say, before precedence is settled.
struct Fields {
  EvtFormat format = EvtFormat::kEvt3;
  EvtFormat evt = EvtFormat::kEvt3;
  bool has_format = false;
  bool has_evt = false;
  std::uint32_t format_width = 0;
  std::uint32_t format_height = 0;
  SensorSize geometry;
  SensorSize sensor;
  bool little_endian = false;
};

std::string_view trimmed(std::string_view text) noexcept {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t' || text.back() == '\r'))
    text.remove_suffix(1);
  return text;
}

// The part before `separator`, which leaves `text` together with it.
std::string_view cut(std::string_view& text, char separator) noexcept {
  std::size_t at = 0;
  while (at < text.size() && text[at] != separator) ++at;
  const std::string_view head(text.data(), at);
  text.remove_prefix(at < text.size() ? at + 1 : at);
  return head;
}

bool side_of(std::string_view text, std::uint32_t& side_px) noexcept {
  std::uint32_t value = 0;
  for (const char c : text) {
    if (c < '0' || c > '9') return false;
    value = value * 10 + static_cast<std::uint32_t>(c - '0');
    if (value > kMaxSidePx) return false;
  }
  side_px = value;
  return value > 0;
}

bool equal_ignoring_case(std::string_view a, std::string_view b) noexcept {
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + ('a' - 'A')) : c; };
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (lower(a[i]) != lower(b[i])) return false;
  }
  return true;
}

bool contains_ignoring_case(std::string_view text, std::string_view word) noexcept {
  for (std::size_t i = 0; i + word.size() <= text.size(); ++i) {
    if (equal_ignoring_case({text.data() + i, word.size()}, word)) return true;
  }
  return false;
}

SensorSize size_of_sensor(std::string_view name) noexcept {
  struct Known {
    std::string_view word;
    SensorSize size;
  };
  constexpr Known kKnown[] = {
      {"imx636", {1280, 720}}, {"imx646", {640, 480}}, {"imx647", {640, 480}},
      {"genx320", {320, 320}}, {"gen4", {1280, 720}},  {"gen3", {640, 480}},
  };
  for (const Known& known : kKnown) {
    if (contains_ignoring_case(name, known.word)) return known.size;
  }
  return {};
}

SensorSize size_of_generation(std::string_view generation) noexcept {
  if (generation.starts_with('3')) return {640, 480};
  if (generation.starts_with('4')) return {1280, 720};
  return {};
}

void copy(std::string_view text, std::span<char> out) noexcept {
  std::size_t n = 0;
  for (; n < text.size() && n + 1 < out.size(); ++n) out[n] = text[n];
  out[n] = '\0';
}

Status take_endianness(std::string_view value, std::int64_t line, Fields& fields) noexcept {
  if (value != "little" && value != "legacy") return {StatusCode::kUnsupportedFormat, "endianness", line};
  fields.little_endian = value == "little";
  return {};
}

// "EVT3;height=720;width=1280"
Status take_format(std::string_view value, std::int64_t line, Fields& fields) noexcept {
  const std::string_view name = trimmed(cut(value, ';'));
  if (name == "EVT3") {
    fields.format = EvtFormat::kEvt3;
  } else if (name == "EVT21") {
    fields.format = EvtFormat::kEvt21;
  } else if (name == "EVT2") {
    fields.format = EvtFormat::kEvt2;
  } else {
    return {StatusCode::kUnsupportedFormat, "format", line};
  }
  fields.has_format = true;
  while (!value.empty()) {
    std::string_view option = trimmed(cut(value, ';'));
    const std::string_view key = trimmed(cut(option, '='));
    option = trimmed(option);
    if (key == "width" && !side_of(option, fields.format_width)) {
      return {StatusCode::kBadHeader, "width under format", line};
    }
    if (key == "height" && !side_of(option, fields.format_height)) {
      return {StatusCode::kBadHeader, "height under format", line};
    }
    if (key == "endianness") {
      if (const Status status = take_endianness(option, line, fields); !status.ok()) return status;
    }
  }
  return {};
}

Status take_evt(std::string_view value, std::int64_t line, Fields& fields) noexcept {
  if (value == "3.0") {
    fields.evt = EvtFormat::kEvt3;
  } else if (value == "2.1") {
    fields.evt = EvtFormat::kEvt21;
  } else if (value == "2.0") {
    fields.evt = EvtFormat::kEvt2;
  } else {
    return {StatusCode::kUnsupportedFormat, "evt", line};
  }
  fields.has_evt = true;
  return {};
}

// "1280x720"
Status take_geometry(std::string_view value, std::int64_t line, Fields& fields) noexcept {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  const std::string_view first = cut(value, 'x');
  if (!side_of(first, width) || !side_of(value, height)) return {StatusCode::kBadHeader, "geometry", line};
  fields.geometry = {static_cast<std::uint16_t>(width), static_cast<std::uint16_t>(height)};
  return {};
}

Status take_line(std::string_view text, std::int64_t line, Fields& fields, RawHeader& header) noexcept {
  text = trimmed(text);
  const std::string_view key = cut(text, ' ');
  const std::string_view value = trimmed(text);
  if (key == "format") return take_format(value, line, fields);
  if (key == "evt") return take_evt(value, line, fields);
  if (key == "geometry") return take_geometry(value, line, fields);
  if (key == "endianness") return take_endianness(value, line, fields);
  if (key == "sensor_name") {
    copy(value, header.sensor_name);
    fields.sensor = size_of_sensor(value);
  }
  if (fields.sensor.width_px == 0) {
    if (key == "sensor_generation" || key == "generation") fields.sensor = size_of_generation(value);
    if (key == "plugin_name" || key == "plugin_integrator_name") fields.sensor = size_of_sensor(value);
  }
  if (key == "serial_number") copy(value, header.serial_number);
  if (key == "date" || key == "Date") copy(value, header.date);
  return {};
}

Status settle(const Fields& fields, std::int64_t line, RawHeader& header) noexcept {
  if (!fields.has_format && !fields.has_evt)
    return {StatusCode::kBadHeader, "neither format nor evt is there", line};
  header.format = fields.has_format ? fields.format : fields.evt;
  if (header.format == EvtFormat::kEvt21 && !fields.little_endian) header.format = EvtFormat::kEvt21Legacy;
  header.size = fields.geometry.width_px != 0 ? fields.geometry : fields.sensor;
  if (fields.format_width != 0 && fields.format_height != 0) {
    header.size = {static_cast<std::uint16_t>(fields.format_width),
                   static_cast<std::uint16_t>(fields.format_height)};
  }
  if (header.size.width_px == 0)
    return {StatusCode::kBadHeader, "geometry is missing, and the sensor not known", line};
  return {};
}

}  // namespace

const char* to_string(EvtFormat format) noexcept {
  switch (format) {
    case EvtFormat::kEvt2:
      return "EVT2";
    case EvtFormat::kEvt21:
      return "EVT2.1";
    case EvtFormat::kEvt21Legacy:
      return "EVT2.1 (legacy order)";
    case EvtFormat::kEvt3:
      return "EVT3";
  }
  return "";
}

Status parse_raw_header(std::span<const std::byte> file, RawHeader& header) noexcept {
  header = {};
  Fields fields;
  std::int64_t line = 1;
  for (;; ++line) {
    const std::span<const std::byte> rest = file.subspan(header.header_bytes);
    if (rest.size() < 2 || rest[0] != std::byte{'%'} || rest[1] != std::byte{' '}) break;
    if (line > kMaxLines) return {StatusCode::kBadHeader, "no end of the header", line};
    char text[kMaxLineBytes];
    std::size_t length = 0;
    while (length < rest.size() && length < kMaxLineBytes && rest[length] != std::byte{'\n'}) {
      text[length] = static_cast<char>(rest[length]);
      ++length;
    }
    if (length == rest.size() || length == kMaxLineBytes)
      return {StatusCode::kBadHeader, "line without end", line};
    header.header_bytes += length + 1;
    const std::string_view content(text + 2, length - 2);
    if (trimmed(content) == "end") break;
    if (const Status status = take_line(content, line, fields, header); !status.ok()) return status;
  }
  if (header.header_bytes == 0) return {StatusCode::kBadHeader, "the file does not begin with \"% \"", line};
  return settle(fields, line, header);
}

}  // namespace egofocus
