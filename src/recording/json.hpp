// An ordered list of facts that prints as JSON for programs and as aligned text for people.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "recording/number_text.hpp"

namespace egofocus::recording {

inline std::string json_text(std::string_view value) {
  std::string text = "\"";
  for (const char c : value) {
    if (c == '"' || c == '\\') {
      text += '\\';
      text += c;
    } else if (static_cast<unsigned char>(c) < 0x20) {
      char code[8];
      std::snprintf(code, sizeof code, "\\u%04x", static_cast<unsigned>(static_cast<unsigned char>(c)));
      text += code;
    } else {
      text += c;
    }
  }
  return text + "\"";
}

class Json {
 public:
  Json& add(std::string key, std::string_view value) {
    return put(std::move(key), json_text(value), std::string(value));
  }
  Json& add(std::string key, const char* value) { return add(std::move(key), std::string_view(value)); }
  Json& add(std::string key, bool value) {
    return put(std::move(key), value ? "true" : "false", value ? "yes" : "no");
  }

  /// JSON has no infinity and no NaN: they become null.
  template <typename Number>
  requires(std::is_arithmetic_v<Number> && !std::is_same_v<Number, bool>) Json& add(std::string key,
                                                                                    Number value) {
    const std::string text = number_text(value);
    const bool is_finite = !std::is_floating_point_v<Number> || std::isfinite(static_cast<double>(value));
    return put(std::move(key), is_finite ? text : "null", text);
  }

  Json& add(std::string key, const Json& value) {
    return put(std::move(key), value.json(), "\n" + value.text("  "));
  }
  Json& add(std::string key, const std::vector<Json>& values) {
    std::string json = "[";
    std::string text;
    for (const Json& value : values) {
      json += (json.size() > 1 ? ", " : "") + value.json();
      text += "\n" + value.text("  ");
    }
    return put(std::move(key), json + "]", text);
  }

  Json& add(std::string key, std::span<const double> values) {
    std::string json = "[";
    std::string text;
    for (const double value : values) {
      json += (json.size() > 1 ? ", " : "") + (std::isfinite(value) ? number_text(value) : "null");
      text += (text.empty() ? "" : " ") + number_text(value);
    }
    return put(std::move(key), json + "]", text);
  }

  /// {"key": value, ...} on one line.
  [[nodiscard]] std::string json() const {
    std::string out = "{";
    for (const Entry& entry : entries_)
      out += (out.size() > 1 ? ", " : "") + json_text(entry.key) + ": " + entry.json;
    return out + "}";
  }

  /// One `key   value` a line, without the last line's end.
  [[nodiscard]] std::string text(const std::string& indent = "") const {
    std::size_t widest = 0;
    for (const Entry& entry : entries_) widest = std::max(widest, entry.key.size());
    std::string out;
    for (const Entry& entry : entries_) {
      std::string value = entry.text;
      for (std::size_t at = value.find('\n'); at != std::string::npos; at = value.find('\n', at + 1))
        value.insert(at + 1, indent);
      out += (out.empty() ? "" : "\n") + indent + entry.key +
             std::string(widest - entry.key.size() + 2, ' ') + value;
    }
    return out;
  }

 private:
  struct Entry {
    std::string key;
    std::string json;
    std::string text;
  };
  Json& put(std::string key, std::string json, std::string text) {
    entries_.push_back({std::move(key), std::move(json), std::move(text)});
    return *this;
  }
  std::vector<Entry> entries_;
};

}  // namespace egofocus::recording
