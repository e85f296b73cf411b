// Decimal numbers in text, without locale, heap or libm: the same bits on every machine.
// Thread: any. RT: yes, O(characters).
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace egofocus {

/// value = (negative ? -1 : 1) * digits * 10^exponent
struct Decimal {
  std::uint64_t digits = 0;
  std::int32_t exponent = 0;
  bool negative = false;
};

/// Reads [+-]digits[.digits][(e|E)[+-]digits] at the start of `text`; one digit at least must stand before
/// the exponent. Significant digits after the 19th are cut. Returns the characters read, 0 if there is no
/// number.
std::size_t scan_decimal(std::string_view text, Decimal& number) noexcept;

/// Correctly rounded for up to 15 significant digits and exponents of -22..22 (all 53 bits of them); else
/// within 2 ulp for each 22 powers of ten. Too small becomes 0; too large is an error (false).
bool to_double(const Decimal& number, double& value) noexcept;

/// Seconds -> microseconds, exactly: the largest whole number of microseconds that is not above. False if it
/// does not fit into int64.
bool to_microseconds(const Decimal& seconds, std::int64_t& t_us) noexcept;

/// Seconds -> microseconds, exactly: the nearest whole number, halves away from zero. False if it does not
/// fit into int64.
bool to_nearest_microsecond(const Decimal& seconds, std::int64_t& t_us) noexcept;

}  // namespace egofocus
