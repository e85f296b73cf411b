// A DBC file, read at run time: which bits of which CAN frame are which signal.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "egofocus/status.hpp"

namespace egofocus {

inline constexpr std::size_t kMaxDbcName = 63;  ///< characters, without the NUL

/// Physical value = raw * factor + offset.
struct DbcSignal {
  enum class Number : std::uint8_t { kUnsigned, kSigned, kFloat32, kFloat64 };
  struct Range {
    std::uint64_t first = 0;
    std::uint64_t last = 0;
  };
  static constexpr std::size_t kMaxRanges = 4;

  char name[kMaxDbcName + 1] = {};
  double factor = 1;
  double offset = 0;
  /// Bit b is bit b % 8 of byte b / 8. Intel: the least significant bit of the signal, which grows upwards.
  /// Motorola: the most significant one; the signal goes on downwards and, after bit 0 of a byte, at bit 7 of
  /// the next.
  std::uint16_t start_bit = 0;
  std::uint8_t length_bits = 0;  ///< 1..64
  bool motorola = false;
  Number number = Number::kUnsigned;
  /// Multiplexing: the signal is in a frame only while the multiplexer's raw value is in one of the ranges.
  bool is_multiplexer = false;
  std::int16_t multiplexer = -1;  ///< index into Dbc::signals, or -1: always there
  std::uint8_t range_count = 0;
  Range ranges[kMaxRanges];
};

struct DbcMessage {
  char name[kMaxDbcName + 1] = {};
  std::uint32_t id = 0;  ///< 11 bits, or 29 bits if `extended`
  bool extended = false;
  bool parameter_group = false;  ///< J1939, by the attribute VFrameFormat: the id stands for its whole group
  std::uint8_t length = 0;       ///< bytes, 0..64
  std::uint16_t first_signal = 0;
  std::uint16_t signal_count = 0;
};

/// What was kept of a file. Fixed capacity, about 45 kB: not for a small stack.
struct Dbc {
  static constexpr std::size_t kMaxMessages = 64;
  static constexpr std::size_t kMaxSignals = 256;
  static constexpr int kMaxMultiplexers = 8;  ///< one above the other

  DbcMessage messages[kMaxMessages];
  DbcSignal signals[kMaxSignals];  ///< those of one message stand together
  std::size_t message_count = 0;
  std::size_t signal_count = 0;

  /// nullptr if there is none of that name.
  [[nodiscard]] const DbcMessage* find_message(std::string_view name) const noexcept;
  [[nodiscard]] const DbcSignal* find_signal(const DbcMessage& message, std::string_view name) const noexcept;
};

/// Reads the messages named in `wanted` (all of them if it is empty) into `dbc`, whose former content is
/// lost. A vehicle's file may be far larger than the capacity: only what is kept counts, and only what is
/// kept is checked. A wanted message that the file lacks is no error here. Errors: kParse, with the line
/// (from 1) and the reason; `dbc` is then empty. Thread: any. RT: no heap, no locale; O(text), for set-up.
[[nodiscard]] Status read_dbc(std::string_view text, std::span<const std::string_view> wanted,
                              Dbc& dbc) noexcept;

/// False if the frame is too short for the signal. `raw` has the signal's bits at its low end, not
/// sign-extended. Thread: any. RT: yes.
bool decode_raw(const DbcSignal& signal, std::span<const std::uint8_t> data, std::uint64_t& raw) noexcept;

/// The physical value of such a raw one. May be NaN or infinite for the two float kinds.
/// Thread: any. RT: yes.
double physical_value(const DbcSignal& signal, std::uint64_t raw) noexcept;

/// Both in one step; does not look at multiplexing.
/// Thread: any. RT: yes.
bool decode_signal(const DbcSignal& signal, std::span<const std::uint8_t> data, double& value) noexcept;

/// Whether the signal is in this frame: true without multiplexing, false if the frame is too short for a
/// multiplexer. Thread: any. RT: yes.
bool is_present(const Dbc& dbc, const DbcSignal& signal, std::span<const std::uint8_t> data) noexcept;

/// Puts the low bits of `raw` in place and leaves all others. False if the frame is too short.
/// Thread: any. RT: yes.
bool encode_raw(const DbcSignal& signal, std::uint64_t raw, std::span<std::uint8_t> data) noexcept;

/// Puts the nearest raw value in place; integers are limited to what the bits hold. False if the frame is too
/// short or the value is not finite. Thread: any. RT: yes.
bool encode_signal(const DbcSignal& signal, double value, std::span<std::uint8_t> data) noexcept;

}  // namespace egofocus
