#include "recording/text_events.hpp"

#include <algorithm>

#include "core/decimal.hpp"
#include "hal/text_words.hpp"

namespace egofocus::recording {
namespace {

constexpr std::int64_t kMaxCoordinate = 65535;

bool take_integer(std::string_view& line, std::int64_t low, std::int64_t high, std::int64_t& value) {
  const std::string_view word = take_word(line);
  Decimal number;
  if (word.empty() || scan_decimal(word, number) != word.size()) return false;
  double exact = 0;
  if (!to_double(number, exact) || !(exact >= static_cast<double>(low) && exact <= static_cast<double>(high)))
    return false;
  value = static_cast<std::int64_t>(exact);
  return static_cast<double>(value) == exact;
}

bool parse_event(std::string_view line, Event& event) {
  const std::string_view time = take_word(line);
  Decimal seconds;
  std::int64_t x = 0;
  std::int64_t y = 0;
  std::int64_t polarity = 0;
  if (scan_decimal(time, seconds) != time.size() || !to_microseconds(seconds, event.t_us) ||
      !take_integer(line, 0, kMaxCoordinate, x) || !take_integer(line, 0, kMaxCoordinate, y) ||
      !take_integer(line, -1, 1, polarity) || !take_word(line).empty()) {
    return false;
  }
  event.x = static_cast<std::uint16_t>(x);
  event.y = static_cast<std::uint16_t>(y);
  event.polarity = polarity == 1 ? 1 : 0;
  return true;
}

}  // namespace

TextEvents parse_text_events(std::string_view text,
                             const std::function<void(std::size_t, std::size_t)>& progress) {
  TextEvents result;
  std::string_view rest = text;
  while (!rest.empty()) {
    const std::string_view line = rest.substr(0, rest.find('\n'));
    rest.remove_prefix(std::min(line.size() + 1, rest.size()));
    ++result.lines;
    if (progress && result.lines % 65536 == 0) progress(text.size() - rest.size(), text.size());
    std::string_view peek = line;
    const std::string_view first = take_word(peek);
    Event event;
    if (first.empty() || first.front() == '#') {
      ++result.blank;
    } else if (!parse_event(line, event)) {
      ++result.malformed;
    } else if (!result.events.empty() && event.t_us < result.events.back().t_us) {
      ++result.out_of_order;
    } else {
      result.events.push_back(event);
    }
  }
  if (progress) progress(text.size(), text.size());
  return result;
}

}  // namespace egofocus::recording
