#include "hal/candump_decoder.hpp"

#include "core/decimal.hpp"
#include "hal/text_words.hpp"

namespace egofocus {
namespace {

constexpr std::uint32_t kErrorFlag = 0x20000000;
constexpr std::uint32_t kExtendedMask = 0x1FFFFFFF;
constexpr std::uint32_t kStandardMask = 0x7FF;

enum class LineKind { kData, kError, kRemote, kUnknown };

int hex_digit(char c) noexcept {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  return -1;
}

// "(1436509052.249713)", with six or nine decimals.
bool parse_time(std::string_view word, std::int64_t& t_us) noexcept {
  if (word.size() < 3 || word.front() != '(' || word.back() != ')') return false;
  word.remove_prefix(1);
  word.remove_suffix(1);
  const std::size_t point = index_of(word, '.');
  if (point == 0 || point == word.size()) return false;
  const std::size_t decimals = word.size() - point - 1;
  if (decimals != 6 && decimals != 9) return false;
  for (std::size_t i = 0; i < word.size(); ++i) {
    if (i != point && (word[i] < '0' || word[i] > '9')) return false;
  }
  Decimal seconds;
  return scan_decimal(word, seconds) == word.size() && to_microseconds(seconds, t_us);
}

// Pairs of hexadecimal digits, each pair with or without a dot before it; what was read is taken off `text`.
std::uint8_t take_bytes(std::string_view& text, std::uint8_t max, std::uint8_t* data) noexcept {
  std::uint8_t count = 0;
  while (count < max) {
    const std::size_t at = !text.empty() && text.front() == '.' ? 1 : 0;
    if (text.size() < at + 2) break;
    const int high = hex_digit(text[at]);
    const int low = hex_digit(text[at + 1]);
    if (high < 0 || low < 0) break;
    data[count++] = static_cast<std::uint8_t>(high * 16 + low);
    text.remove_prefix(at + 2);
  }
  return count;
}

// "_9": the length code as sent, above 8, of a frame with eight bytes.
bool is_raw_length_code(std::string_view text) noexcept {
  return text.size() == 2 && text[0] == '_' && hex_digit(text[1]) > 8;
}

// What follows "R" in a remote frame: nothing, or a length and perhaps its code.
bool is_remote_length(std::string_view text) noexcept {
  if (text.empty()) return true;
  const int length = hex_digit(text[0]);
  text.remove_prefix(1);
  return length >= 0 && length <= 8 && (text.empty() || (length == 8 && is_raw_length_code(text)));
}

// "044#2A36", "18F02A80#R", "123##1A0B1".
LineKind parse_frame(std::string_view word, CanFrame& frame) noexcept {
  const std::size_t hash = index_of(word, '#');
  if (hash == word.size() || (hash != 3 && hash != 8)) return LineKind::kUnknown;
  std::uint32_t id = 0;
  for (const char c : first_of(word, hash)) {
    const int digit = hex_digit(c);
    if (digit < 0) return LineKind::kUnknown;
    id = id << 4 | static_cast<std::uint32_t>(digit);
  }
  frame.extended = hash == 8;
  const bool is_error = frame.extended && (id & kErrorFlag) != 0;
  if (!frame.extended && id > kStandardMask) return LineKind::kUnknown;
  frame.id = id & kExtendedMask;

  std::string_view rest = word;
  rest.remove_prefix(hash + 1);
  if (!rest.empty() && (rest[0] == 'R' || rest[0] == 'r')) {
    rest.remove_prefix(1);
    return is_remote_length(rest) ? LineKind::kRemote : LineKind::kUnknown;
  }
  frame.fd = !rest.empty() && rest[0] == '#';
  if (frame.fd) {
    if (rest.size() < 2 || hex_digit(rest[1]) < 0) return LineKind::kUnknown;
    rest.remove_prefix(2);
  }
  frame.length = take_bytes(rest, frame.fd ? 64 : 8, frame.data);
  const bool ends_well = rest.empty() || (!frame.fd && frame.length == 8 && is_raw_length_code(rest));
  if (!ends_well) return LineKind::kUnknown;
  return is_error ? LineKind::kError : LineKind::kData;
}

// "(time) interface frame [R|T]"
LineKind parse_line(std::string_view line, CanFrame& frame) noexcept {
  if (!parse_time(take_word(line), frame.t_us)) return LineKind::kUnknown;
  if (take_word(line).empty()) return LineKind::kUnknown;
  const LineKind kind = parse_frame(take_word(line), frame);
  const std::string_view direction = take_word(line);
  if (!direction.empty() && direction != "R" && direction != "T") return LineKind::kUnknown;
  return take_word(line).empty() ? kind : LineKind::kUnknown;
}

// "DROPCOUNT: dropped 3 CAN frames on 'can0' socket (total drops 3)"; 0 if it says no number.
std::uint64_t dropped_frames(std::string_view line) noexcept {
  take_word(line);
  take_word(line);
  Decimal number;
  const std::string_view word = take_word(line);
  const bool whole = scan_decimal(word, number) == word.size() && !number.negative && number.exponent == 0;
  return whole && number.digits <= UINT32_MAX ? number.digits : 0;
}

}  // namespace

bool CandumpDecoder::decode_line(std::string_view line, CanFrame& frame) noexcept {
  std::string_view rest = line;
  const std::string_view first = take_word(rest);
  if (first.empty()) {
    ++counters_.blank;
    return false;
  }
  if (first.starts_with("DROPCOUNT")) {
    ++counters_.drop_notices;
    counters_.recorder_drops += dropped_frames(line);
    return false;
  }
  frame = CanFrame{};
  switch (parse_line(line, frame)) {
    case LineKind::kUnknown:
      ++counters_.unknown;
      return false;
    case LineKind::kError:
      ++counters_.error_frames;
      return false;
    case LineKind::kRemote:
      ++counters_.remote_frames;
      return false;
    case LineKind::kData:
      break;
  }
  ++counters_.frames;
  if (frame.t_us < latest_us_) {
    ++counters_.out_of_order;
  } else {
    latest_us_ = frame.t_us;
  }
  return true;
}

Decoded CandumpDecoder::decode(std::span<const std::byte> bytes, std::span<CanFrame> out,
                               bool last) noexcept {
  return decode_lines(
      lines_, bytes, out, last, counters_,
      [this](std::string_view line, CanFrame& sample) noexcept { return decode_line(line, sample); });
}

Decoded CandumpDecoder::feed(std::span<const std::byte> bytes, std::span<CanFrame> out) noexcept {
  return decode(bytes, out, false);
}

Decoded CandumpDecoder::finish(std::span<const std::byte> bytes, std::span<CanFrame> out) noexcept {
  return decode(bytes, out, true);
}

}  // namespace egofocus
