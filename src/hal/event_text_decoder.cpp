#include "hal/event_text_decoder.hpp"

#include "core/decimal.hpp"
#include "hal/text_words.hpp"

namespace egofocus {
namespace {

struct Fields {
  std::int64_t t_us = 0;
  std::int64_t x = 0;
  std::int64_t y = 0;
  std::int64_t polarity = 0;
};

bool take_time(std::string_view& line, std::int64_t& t_us) noexcept {
  const std::string_view word = take_word(line);
  Decimal seconds;
  return !word.empty() && scan_decimal(word, seconds) == word.size() && to_nearest_microsecond(seconds, t_us);
}

// A whole number, which may be written as 12, 12.0 or 1.2e+01. Beyond +-10^9 it is none of ours.
bool take_whole(std::string_view& line, std::int64_t& value) noexcept {
  const std::string_view word = take_word(line);
  Decimal number;
  if (word.empty() || scan_decimal(word, number) != word.size()) return false;
  for (; number.exponent < 0 && number.digits % 10 == 0 && number.digits != 0; ++number.exponent)
    number.digits /= 10;
  for (; number.exponent > 0 && number.digits <= 1000000000; --number.exponent) {
    if (number.digits == 0) break;
    number.digits *= 10;
  }
  if (number.digits > 1000000000 || (number.digits != 0 && number.exponent != 0)) return false;
  value =
      number.negative ? -static_cast<std::int64_t>(number.digits) : static_cast<std::int64_t>(number.digits);
  return true;
}

bool parse(std::string_view line, Fields& fields) noexcept {
  return take_time(line, fields.t_us) && take_whole(line, fields.x) && take_whole(line, fields.y) &&
         take_whole(line, fields.polarity) && fields.polarity >= -1 && fields.polarity <= 1 &&
         take_word(line).empty();
}

}  // namespace

bool EventTextDecoder::decode_line(std::string_view line, Event& event) noexcept {
  std::string_view rest = line;
  const std::string_view first = take_word(rest);
  if (first.empty() || first.front() == '#') {
    ++counters_.blank;
    return false;
  }
  Fields fields;
  if (!parse(line, fields)) {
    ++counters_.malformed;
    return false;
  }
  if (fields.x < 0 || fields.x >= size_.width_px || fields.y < 0 || fields.y >= size_.height_px) {
    ++counters_.out_of_range;
    return false;
  }
  ++counters_.events;
  if (fields.t_us < previous_us_) ++counters_.out_of_order;
  previous_us_ = fields.t_us;
  event = {.t_us = fields.t_us,
           .x = static_cast<std::uint16_t>(fields.x),
           .y = static_cast<std::uint16_t>(fields.y),
           .polarity = static_cast<std::uint8_t>(fields.polarity == 1)};
  return true;
}

Decoded EventTextDecoder::decode(std::span<const std::byte> bytes, std::span<Event> out, bool last) noexcept {
  return decode_lines(
      lines_, bytes, out, last, counters_,
      [this](std::string_view line, Event& sample) noexcept { return decode_line(line, sample); });
}

}  // namespace egofocus
