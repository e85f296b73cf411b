#include "core/decimal.hpp"

namespace egofocus {
namespace {

constexpr std::uint64_t kExactIntegers = std::uint64_t{1} << 53;
constexpr std::int32_t kExactPower = 22;  // 10^22 is the largest power of ten that a double holds exactly
constexpr double kPowers[kExactPower + 1] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                             1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                             1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
constexpr std::uint64_t kMaxDigits = 999999999999999999u;  // below it, one more digit fits
constexpr std::int32_t kMaxExponent = 100000;              // beyond any double, far from overflow

bool is_digit(char c) noexcept {
  return c >= '0' && c <= '9';
}

}  // namespace

std::size_t scan_decimal(std::string_view text, Decimal& number) noexcept {
  number = Decimal{};
  std::size_t at = 0;
  if (at < text.size() && (text[at] == '+' || text[at] == '-')) number.negative = text[at++] == '-';

  bool any_digit = false;
  bool after_point = false;
  for (; at < text.size(); ++at) {
    const char c = text[at];
    if (c == '.' && !after_point) {
      after_point = true;
      continue;
    }
    if (!is_digit(c)) break;
    any_digit = true;
    const bool fits = number.digits <= kMaxDigits;
    if (fits) number.digits = number.digits * 10 + static_cast<std::uint64_t>(c - '0');
    // A digit that was taken after the point, or cut before it, moves the point.
    if (fits == after_point && number.exponent > -kMaxExponent && number.exponent < kMaxExponent) {
      number.exponent += fits ? -1 : 1;
    }
  }
  if (!any_digit) return 0;

  if (at < text.size() && (text[at] == 'e' || text[at] == 'E')) {
    std::size_t end = at + 1;
    bool negative = false;
    if (end < text.size() && (text[end] == '+' || text[end] == '-')) negative = text[end++] == '-';
    const std::size_t first = end;
    std::int32_t exponent = 0;
    for (; end < text.size() && is_digit(text[end]); ++end) {
      if (exponent < kMaxExponent) exponent = exponent * 10 + (text[end] - '0');
    }
    if (end > first) {  // else the letter belongs to what follows the number
      number.exponent += negative ? -exponent : exponent;
      at = end;
    }
  }
  return at;
}

bool to_double(const Decimal& number, double& value) noexcept {
  std::uint64_t digits = number.digits;
  std::int32_t exponent = number.exponent;
  // "1.500000000000000000e+00" has few significant digits; only without its zeros is it exact.
  while (digits > kExactIntegers && digits % 10 == 0) {
    digits /= 10;
    ++exponent;
  }
  double magnitude = static_cast<double>(digits);
  if (digits == 0 || exponent < -400) {
    magnitude = 0;
    exponent = 0;
  }
  if (exponent > 400) return false;
  for (; exponent > kExactPower; exponent -= kExactPower) magnitude *= kPowers[kExactPower];
  for (; exponent < -kExactPower; exponent += kExactPower) magnitude /= kPowers[kExactPower];
  // Both operands are exact on the common path, so IEEE rounds this one operation correctly.
  magnitude = exponent < 0 ? magnitude / kPowers[-exponent] : magnitude * kPowers[exponent];
  if (!(magnitude - magnitude == 0)) return false;
  value = number.negative ? -magnitude : magnitude;
  return true;
}

bool to_microseconds(const Decimal& seconds, std::int64_t& t_us) noexcept {
  std::uint64_t magnitude = seconds.digits;
  bool whole = true;
  std::int32_t exponent = seconds.exponent + 6;
  for (; exponent < 0 && magnitude != 0; ++exponent) {
    whole = whole && magnitude % 10 == 0;
    magnitude /= 10;
  }
  for (; exponent > 0 && magnitude != 0; --exponent) {
    if (magnitude > static_cast<std::uint64_t>(INT64_MAX) / 10) return false;
    magnitude *= 10;
  }
  if (seconds.negative && !whole) ++magnitude;
  if (magnitude > static_cast<std::uint64_t>(INT64_MAX)) return false;
  t_us = seconds.negative ? -static_cast<std::int64_t>(magnitude) : static_cast<std::int64_t>(magnitude);
  return true;
}

bool to_nearest_microsecond(const Decimal& seconds, std::int64_t& t_us) noexcept {
  Decimal magnitude{.digits = seconds.digits, .exponent = seconds.exponent, .negative = false};
  std::uint64_t first_cut = 0;  // the first digit after the microsecond decides alone
  for (; magnitude.exponent < -6 && magnitude.digits != 0; ++magnitude.exponent) {
    first_cut = magnitude.digits % 10;
    magnitude.digits /= 10;
  }
  if (magnitude.exponent < -6) first_cut = 0;
  if (!to_microseconds(magnitude, t_us)) return false;
  if (first_cut >= 5) ++t_us;  // digits were cut, so t_us is below 2^64 / 10
  if (seconds.negative) t_us = -t_us;
  return true;
}

}  // namespace egofocus
