#include "recording/number_text.hpp"

namespace egofocus::recording {

bool parse_seconds(std::string_view word, std::int64_t& t_us) {
  // Exponents (1.5e9) are rare: they go through a double, whose 53 bits hold 285 years of microseconds.
  if (word.find_first_of("eE") != std::string_view::npos) {
    double seconds = 0;
    if (!parse_number(word, seconds) || !(seconds > -9e12 && seconds < 9e12)) return false;
    t_us = static_cast<std::int64_t>(seconds * 1e6 + (seconds < 0 ? -0.5 : 0.5));
    return true;
  }
  const bool negative = !word.empty() && word[0] == '-';
  if (!word.empty() && (negative || word[0] == '+')) word.remove_prefix(1);
  constexpr std::int64_t kMaxSeconds = INT64_MAX / 1000000 - 1;
  std::int64_t whole = 0;
  std::int64_t micros = 0;
  std::size_t i = 0;
  std::size_t digits = 0;
  for (; i < word.size() && word[i] >= '0' && word[i] <= '9'; ++i, ++digits) {
    whole = whole * 10 + (word[i] - '0');
    if (whole > kMaxSeconds) return false;
  }
  if (i < word.size() && word[i] == '.') {
    ++i;
    std::int64_t unit = 100000;
    bool first_dropped = true;
    for (; i < word.size() && word[i] >= '0' && word[i] <= '9'; ++i, ++digits) {
      if (unit == 0) {
        if (first_dropped && word[i] >= '5') ++micros;
        first_dropped = false;
      }
      micros += unit * (word[i] - '0');
      unit /= 10;
    }
  }
  if (digits == 0 || i != word.size()) return false;
  t_us = whole * 1000000 + micros;
  if (negative) t_us = -t_us;
  return true;
}

std::string seconds_text(std::int64_t t_us) {
  const std::uint64_t size =
      t_us < 0 ? 0 - static_cast<std::uint64_t>(t_us) : static_cast<std::uint64_t>(t_us);
  const std::string micros = std::to_string(size % 1000000);
  return (t_us < 0 ? "-" : "") + std::to_string(size / 1000000) + "." + std::string(6 - micros.size(), '0') +
         micros;
}

}  // namespace egofocus::recording
