// Numbers from and to text, free of locales.
#pragma once

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <string>
#include <string_view>

namespace egofocus::recording {

/// Takes the next blank-separated word off the front of `rest`; empty at the end.
inline std::string_view take_word(std::string_view& rest) {
  constexpr std::string_view kBlank = " \t\r,";
  const std::size_t begin = rest.find_first_not_of(kBlank);
  if (begin == std::string_view::npos) {
    rest = {};
    return {};
  }
  const std::size_t end = std::min(rest.find_first_of(kBlank, begin), rest.size());
  const std::string_view word = rest.substr(begin, end - begin);
  rest = rest.substr(end);
  return word;
}

/// Takes the next line (without its end) off the front of `rest`.
inline std::string_view take_line(std::string_view& rest) {
  const std::size_t end = rest.find('\n');
  const std::string_view line = rest.substr(0, end);
  rest = end == std::string_view::npos ? std::string_view{} : rest.substr(end + 1);
  return line;
}

/// The whole word must be one number; a leading + is allowed.
template <typename Number>
bool parse_number(std::string_view word, Number& value) {
  if (word.size() > 1 && word[0] == '+') word.remove_prefix(1);
  const auto [end, failure] = std::from_chars(word.data(), word.data() + word.size(), value);
  return failure == std::errc() && end == word.data() + word.size();
}

/// Shortest text that reads back as the same bits.
template <typename Number>
std::string number_text(Number value) {
  char buffer[40];
  return {buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr};
}

/// A decimal number of seconds in integer arithmetic, rounded to the nearest microsecond: "0.003811001" ->
/// 3811. False when the word is no plain decimal number or is beyond 292,000 years.
bool parse_seconds(std::string_view word, std::int64_t& t_us);

/// "12.345678"
std::string seconds_text(std::int64_t t_us);

}  // namespace egofocus::recording
