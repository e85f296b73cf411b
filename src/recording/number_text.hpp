// Numbers to text, free of locales. (From text: core/decimal.hpp.)
#pragma once

#include <charconv>
#include <cstdint>
#include <string>

namespace egofocus::recording {

/// Shortest text that reads back as the same bits.
template <typename Number>
std::string number_text(Number value) {
  char buffer[40];
  return {buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr};
}

/// With this many decimals; |value| < 1e15.
inline std::string fixed_text(double value, int decimals) {
  char buffer[64];
  return {buffer,
          std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::fixed, decimals).ptr};
}

/// "12.345678"
inline std::string seconds_text(std::int64_t t_us) {
  const std::uint64_t size =
      t_us < 0 ? 0 - static_cast<std::uint64_t>(t_us) : static_cast<std::uint64_t>(t_us);
  const std::string micros = std::to_string(size % 1000000);
  return (t_us < 0 ? "-" : "") + std::to_string(size / 1000000) + "." + std::string(6 - micros.size(), '0') +
         micros;
}

}  // namespace egofocus::recording
