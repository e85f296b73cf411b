#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <vector>

#include "hal/dbc.hpp"

using namespace egofocus;

namespace {

// The bits of a signal from the least significant one up, walked by the rules of the file format; empty if
// they leave the frame.
std::vector<int> bits_of(const DbcSignal& signal, int frame_bits) {
  std::vector<int> from_start;
  int bit = signal.start_bit;
  for (int i = 0; i < signal.length_bits; ++i) {
    if (bit >= frame_bits) return {};
    from_start.push_back(bit);
    if (!signal.motorola) {
      ++bit;
    } else {
      bit = bit % 8 == 0 ? bit + 15 : bit - 1;
    }
  }
  if (signal.motorola) return {from_start.rbegin(), from_start.rend()};
  return from_start;
}

bool bit_at(const std::uint8_t* data, int bit) {
  return (data[bit / 8] >> (bit % 8) & 1) != 0;
}

DbcSignal make(int start, int length, bool motorola, DbcSignal::Number number) {
  DbcSignal signal;
  signal.start_bit = static_cast<std::uint16_t>(start);
  signal.length_bits = static_cast<std::uint8_t>(length);
  signal.motorola = motorola;
  signal.number = number;
  return signal;
}

}  // namespace

TEST_CASE("dbc: every length, start and order against a walk bit by bit") {
  std::mt19937_64 random(11);
  constexpr int kBytes = 64;
  std::uint8_t frame[kBytes];
  int legal = 0;
  for (int length = 1; length <= 64; ++length) {
    for (int start = 0; start < kBytes * 8; ++start) {
      for (const bool motorola : {false, true}) {
        const DbcSignal signal = make(start, length, motorola, DbcSignal::Number::kUnsigned);
        const std::vector<int> bits = bits_of(signal, kBytes * 8);
        for (auto& byte : frame) byte = static_cast<std::uint8_t>(random());
        std::uint64_t raw = 0;
        const bool ok = decode_raw(signal, frame, raw);
        if (ok == bits.empty()) FAIL("legality of " << start << "|" << length << "@" << !motorola);
        if (!ok) {
          std::uint8_t untouched[kBytes];
          std::memcpy(untouched, frame, kBytes);
          if (encode_raw(signal, 1, frame) || std::memcmp(untouched, frame, kBytes) != 0)
            FAIL("wrote an illegal signal");
          continue;
        }
        ++legal;
        std::uint64_t want = 0;
        for (std::size_t i = 0; i < bits.size(); ++i) want |= std::uint64_t{bit_at(frame, bits[i])} << i;
        if (raw != want)
          FAIL(start << "|" << length << "@" << !motorola << " reads " << raw << ", not " << want);

        std::uint8_t expected[kBytes];
        std::memcpy(expected, frame, kBytes);
        const std::uint64_t value = random();
        for (std::size_t i = 0; i < bits.size(); ++i) {
          const auto mask = static_cast<std::uint8_t>(1 << (bits[i] % 8));
          std::uint8_t& byte = expected[bits[i] / 8];
          byte = static_cast<std::uint8_t>((value >> i & 1) != 0 ? byte | mask : byte & ~mask);
        }
        if (!encode_raw(signal, value, frame)) FAIL("did not write " << start << "|" << length);
        if (std::memcmp(expected, frame, kBytes) != 0)
          FAIL(start << "|" << length << "@" << !motorola << " is written wrongly");
      }
    }
  }
  CHECK(legal == 2 * (512 * 64 - 63 * 64 / 2));
}

TEST_CASE("dbc: a signal needs its bytes and no more") {
  const std::uint8_t data[64] = {};
  std::uint64_t raw = 0;
  const DbcSignal intel = make(13, 11, false, DbcSignal::Number::kUnsigned);  // bits 13..23
  CHECK_FALSE(decode_raw(intel, std::span(data, 2), raw));
  CHECK(decode_raw(intel, std::span(data, 3), raw));
  const DbcSignal motorola = make(1, 10, true, DbcSignal::Number::kUnsigned);  // 2 bits of byte 0, byte 1
  CHECK_FALSE(decode_raw(motorola, std::span(data, 1), raw));
  CHECK(decode_raw(motorola, std::span(data, 2), raw));
  CHECK_FALSE(decode_raw(motorola, std::span(data, 0), raw));
}

TEST_CASE("dbc: signed and unsigned values come back, all lengths and both orders") {
  std::mt19937_64 random(13);
  for (int length = 1; length <= 53; ++length) {
    for (const bool motorola : {false, true}) {
      for (const bool is_signed : {false, true}) {
        using Number = DbcSignal::Number;
        DbcSignal signal =
            make(motorola ? 15 : 9, length, motorola, is_signed ? Number::kSigned : Number::kUnsigned);
        signal.factor = 0.25;
        signal.offset = -12;
        for (int i = 0; i < 50; ++i) {
          const std::uint64_t all = (std::uint64_t{1} << length) - 1;
          std::int64_t number = static_cast<std::int64_t>(random() & all);
          if (i == 0) number = 0;
          if (i == 1) number = static_cast<std::int64_t>(all);
          if (i == 2) number = static_cast<std::int64_t>(all / 2 + 1);
          if (is_signed && number > static_cast<std::int64_t>(all / 2))
            number -= static_cast<std::int64_t>(all) + 1;
          const double value = static_cast<double>(number) * 0.25 - 12;
          std::uint8_t data[16] = {};
          if (i % 2 == 0) std::memset(data, 0xFF, sizeof data);
          double got = 0;
          if (!encode_signal(signal, value, data) || !decode_signal(signal, data, got)) FAIL("does not fit");
          // 53 bits and an offset may need 54
          if (length < 50 ? got != value : !(std::abs(got - value) <= 1))
            FAIL(length << ": " << value << " became " << got);
        }
      }
    }
  }
}

TEST_CASE("dbc: 64-bit extremes") {
  std::uint8_t data[8] = {};
  double value = 0;
  const DbcSignal s = make(0, 64, false, DbcSignal::Number::kSigned);
  const DbcSignal u = make(0, 64, false, DbcSignal::Number::kUnsigned);
  REQUIRE(encode_signal(s, -9223372036854775808.0, data));
  REQUIRE(decode_signal(s, data, value));
  CHECK(value == -9223372036854775808.0);
  REQUIRE(encode_signal(s, 1e30, data));
  CHECK((data[7] == 0x7F && data[0] == 0xFF));
  REQUIRE(encode_signal(u, 1e30, data));
  CHECK((data[7] == 0xFF && data[0] == 0xFF));
  REQUIRE(decode_signal(u, data, value));
  CHECK(value == 18446744073709551616.0);
}

TEST_CASE("dbc: encoding rounds to the nearest and stays in range") {
  std::uint8_t data[1] = {};
  DbcSignal signal = make(0, 8, false, DbcSignal::Number::kUnsigned);
  const auto raw_of = [&](double value) {
    REQUIRE(encode_signal(signal, value, data));
    return static_cast<int>(data[0]);
  };
  CHECK(raw_of(2.49) == 2);
  CHECK(raw_of(2.5) == 3);
  CHECK(raw_of(255.6) == 255);
  CHECK(raw_of(1e9) == 255);
  CHECK(raw_of(-0.4) == 0);
  CHECK(raw_of(-5) == 0);
  signal.number = DbcSignal::Number::kSigned;
  CHECK(raw_of(-2.5) == 0xFD);
  CHECK(raw_of(-200) == 0x80);
  CHECK(raw_of(200) == 0x7F);
  CHECK_FALSE(encode_signal(signal, std::numeric_limits<double>::quiet_NaN(), data));
  CHECK_FALSE(encode_signal(signal, std::numeric_limits<double>::infinity(), data));
}

TEST_CASE("dbc: floats") {
  const DbcSignal f32 = make(7, 32, true, DbcSignal::Number::kFloat32);
  const std::uint8_t one_and_half[4] = {0x3F, 0xC0, 0x00, 0x00};
  double value = 0;
  REQUIRE(decode_signal(f32, one_and_half, value));
  CHECK(value == 1.5);
  const DbcSignal f64 = make(0, 64, false, DbcSignal::Number::kFloat64);
  std::uint8_t data[8] = {};
  REQUIRE(encode_signal(f64, -0.1, data));
  REQUIRE(decode_signal(f64, data, value));
  CHECK(value == -0.1);
  REQUIRE(encode_signal(f32, 1e300, data));
  REQUIRE(decode_signal(f32, data, value));
  CHECK(value == static_cast<double>(std::numeric_limits<float>::max()));
}
