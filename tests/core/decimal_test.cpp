#include "core/decimal.hpp"

#include <catch2/catch.hpp>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <random>
#include <string>

using namespace egofocus;

namespace {

double parse(const std::string& text) {
  Decimal number;
  double value = -999;
  REQUIRE(scan_decimal(text, number) == text.size());
  REQUIRE(to_double(number, value));
  return value;
}

std::int64_t microseconds(const std::string& text) {
  Decimal number;
  std::int64_t t_us = -999;
  REQUIRE(scan_decimal(text, number) == text.size());
  REQUIRE(to_microseconds(number, t_us));
  return t_us;
}

}  // namespace

TEST_CASE("decimals of up to 15 digits are correctly rounded") {
  std::mt19937_64 random(7);
  for (int i = 0; i < 20000; ++i) {
    const std::uint64_t digits = random() % 1000000000000000u >> random() % 50;
    const int exponent = static_cast<int>(random() % 45) - 22;
    char text[64];
    std::snprintf(text, sizeof text, "%s%llue%d", random() % 2 != 0 ? "-" : "",
                  static_cast<unsigned long long>(digits), exponent);
    const double got = parse(text);
    const double want = std::strtod(text, nullptr);
    if (std::memcmp(&got, &want, sizeof got) != 0) FAIL(text << " gave " << got);
  }
}

TEST_CASE("decimals as files write them") {
  CHECK(parse("0.000127465") == 0.000127465);
  CHECK(parse("-4.1768") == -4.1768);
  CHECK(parse("1E-05") == 1e-05);
  CHECK(parse("3.0517578125E-05") == 3.0517578125e-05);
  CHECK(parse("1.500000000000000000e+00") == 1.5);
  CHECK(parse("00000000000000000000000012.5") == 12.5);
  CHECK(parse("1234567890123456789012") == Approx(1234567890123456789012.0).epsilon(1e-15));
  CHECK(parse("0.70710678118654752440084436210485") == Approx(0.70710678118654752).epsilon(1e-15));
  CHECK(parse(".5") == 0.5);
  CHECK(parse("5.") == 5.0);
  CHECK(parse("1e-400") == 0.0);
  CHECK(parse("0e999999999999") == 0.0);
}

TEST_CASE("what is not a number is left alone") {
  Decimal number;
  for (const char* text : {"", "-", "+", ".", "nan", "inf", "-x", "e5"})
    CHECK(scan_decimal(text, number) == 0);
  CHECK(scan_decimal("1.2.3", number) == 3);
  CHECK(scan_decimal("7e", number) == 1);
  CHECK(scan_decimal("7e+", number) == 1);
  double value = 0;
  CHECK(scan_decimal("1e309", number) == 5);
  CHECK_FALSE(to_double(number, value));
  CHECK(scan_decimal("1e99999999", number) == 10);
  CHECK_FALSE(to_double(number, value));
}

TEST_CASE("seconds become microseconds exactly") {
  CHECK(microseconds("1436509052.249713") == 1436509052249713);
  CHECK(microseconds("1436509052.249713999") == 1436509052249713);
  CHECK(microseconds("0.000001") == 1);
  CHECK(microseconds("0.0000009") == 0);
  CHECK(microseconds("-0.0000009") == -1);
  CHECK(microseconds("-1.5") == -1500000);
  CHECK(microseconds("1.741560000000000000e-01") == 174156);
  CHECK(microseconds("9223372036854.775807") == INT64_MAX);
  Decimal number;
  std::int64_t t_us = 0;
  REQUIRE(scan_decimal("9223372036854.775808", number) == 20);
  CHECK_FALSE(to_microseconds(number, t_us));
  REQUIRE(scan_decimal("1e300", number) == 5);
  CHECK_FALSE(to_microseconds(number, t_us));
}
