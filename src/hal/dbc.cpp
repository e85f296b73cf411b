#include "hal/dbc.hpp"

#include <bit>
#include <cfloat>

namespace egofocus {
namespace {

constexpr std::uint64_t low_bits(unsigned count) noexcept {
  return count >= 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << count) - 1;
}

// Calls visit(byte index, lowest bit, bits) for each piece of the signal that lies within one byte: Intel
// signals from the least significant piece upwards, Motorola signals from the most significant one downwards.
template <typename Visit>
void for_each_piece(const DbcSignal& signal, Visit visit) noexcept {
  unsigned byte = signal.start_bit / 8u;
  unsigned bit = signal.start_bit % 8u;
  for (unsigned left = signal.length_bits; left > 0; ++byte) {
    const unsigned room = signal.motorola ? bit + 1 : 8 - bit;
    const unsigned bits = left < room ? left : room;
    visit(byte, signal.motorola ? bit + 1 - bits : bit, bits);
    left -= bits;
    bit = signal.motorola ? 7 : 0;
  }
}

bool fits(const DbcSignal& signal, std::size_t bytes) noexcept {
  // Bits before the signal in its own order; Motorola counts from bit 7 of a byte.
  const std::size_t bit = signal.start_bit % 8u;
  const std::size_t before = signal.start_bit - bit + (signal.motorola ? 7 - bit : bit);
  return before + signal.length_bits <= bytes * 8;
}

// Nearest whole number, ties away from zero, limited to what the bits hold.
std::uint64_t nearest_raw(double value, bool is_signed, unsigned bits) noexcept {
  const bool negative = value < 0;
  if (negative && !is_signed) return 0;
  const std::uint64_t all = low_bits(bits);
  const std::uint64_t largest = !is_signed ? all : negative ? (all >> 1) + 1 : all >> 1;
  const double magnitude = negative ? -value : value;
  if (magnitude >= 18446744073709551616.0) return negative ? 0 - largest : largest;
  auto whole = static_cast<std::uint64_t>(magnitude);
  if (whole < low_bits(53) && magnitude - static_cast<double>(whole) >= 0.5) ++whole;
  if (whole > largest) whole = largest;
  return negative ? 0 - whole : whole;
}

}  // namespace

const DbcMessage* Dbc::find_message(std::string_view name) const noexcept {
  for (std::size_t i = 0; i < message_count; ++i) {
    if (name == messages[i].name) return &messages[i];
  }
  return nullptr;
}

const DbcSignal* Dbc::find_signal(const DbcMessage& message, std::string_view name) const noexcept {
  for (std::size_t i = 0; i < message.signal_count; ++i) {
    const DbcSignal& signal = signals[message.first_signal + i];
    if (name == signal.name) return &signal;
  }
  return nullptr;
}

bool decode_raw(const DbcSignal& signal, std::span<const std::uint8_t> data, std::uint64_t& raw) noexcept {
  if (!fits(signal, data.size())) return false;
  raw = 0;
  unsigned done = 0;
  for_each_piece(signal, [&](unsigned byte, unsigned low, unsigned bits) {
    const std::uint64_t piece = (data[byte] >> low) & low_bits(bits);
    raw = signal.motorola ? raw << bits | piece : raw | piece << done;
    done += bits;
  });
  return true;
}

bool encode_raw(const DbcSignal& signal, std::uint64_t raw, std::span<std::uint8_t> data) noexcept {
  if (!fits(signal, data.size())) return false;
  unsigned done = 0;
  for_each_piece(signal, [&](unsigned byte, unsigned low, unsigned bits) {
    const unsigned shift = signal.motorola ? signal.length_bits - done - bits : done;
    const std::uint64_t piece = (raw >> shift) & low_bits(bits);
    data[byte] = static_cast<std::uint8_t>((data[byte] & ~(low_bits(bits) << low)) | piece << low);
    done += bits;
  });
  return true;
}

double physical_value(const DbcSignal& signal, std::uint64_t raw) noexcept {
  double number = 0;
  switch (signal.number) {
    case DbcSignal::Number::kUnsigned:
      number = static_cast<double>(raw);
      break;
    case DbcSignal::Number::kSigned: {
      const bool negative = (raw >> (signal.length_bits - 1u) & 1) != 0;
      const std::uint64_t extended = negative ? raw | ~low_bits(signal.length_bits) : raw;
      number = static_cast<double>(static_cast<std::int64_t>(extended));
      break;
    }
    case DbcSignal::Number::kFloat32:
      number = std::bit_cast<float>(static_cast<std::uint32_t>(raw));
      break;
    case DbcSignal::Number::kFloat64:
      number = std::bit_cast<double>(raw);
      break;
  }
  return number * signal.factor + signal.offset;
}

bool decode_signal(const DbcSignal& signal, std::span<const std::uint8_t> data, double& value) noexcept {
  std::uint64_t raw = 0;
  if (!decode_raw(signal, data, raw)) return false;
  value = physical_value(signal, raw);
  return true;
}

bool encode_signal(const DbcSignal& signal, double value, std::span<std::uint8_t> data) noexcept {
  const double number = (value - signal.offset) / signal.factor;
  if (!(number - number == 0)) return false;
  std::uint64_t raw = 0;
  switch (signal.number) {
    case DbcSignal::Number::kUnsigned:
      raw = nearest_raw(number, false, signal.length_bits);
      break;
    case DbcSignal::Number::kSigned:
      raw = nearest_raw(number, true, signal.length_bits);
      break;
    case DbcSignal::Number::kFloat32: {
      const double limit = FLT_MAX;
      const double limited = number > limit ? limit : number < -limit ? -limit : number;
      raw = std::bit_cast<std::uint32_t>(static_cast<float>(limited));
      break;
    }
    case DbcSignal::Number::kFloat64:
      raw = std::bit_cast<std::uint64_t>(number);
      break;
  }
  return encode_raw(signal, raw, data);
}

bool is_present(const Dbc& dbc, const DbcSignal& signal, std::span<const std::uint8_t> data) noexcept {
  const DbcSignal* at = &signal;
  for (int depth = 0; at->multiplexer >= 0; ++depth) {
    if (depth == Dbc::kMaxMultiplexers) return false;
    const DbcSignal& multiplexer = dbc.signals[at->multiplexer];
    std::uint64_t selected = 0;
    if (!decode_raw(multiplexer, data, selected)) return false;
    bool in_range = false;
    for (std::size_t i = 0; i < at->range_count; ++i) {
      in_range = in_range || (selected >= at->ranges[i].first && selected <= at->ranges[i].last);
    }
    if (!in_range) return false;
    at = &multiplexer;
  }
  return true;
}

}  // namespace egofocus
