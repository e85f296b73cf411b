// Words of iniVation's streams, built field by field from their layouts; nothing is shared with the library.
#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <vector>

#include "made_evt_words.hpp"

namespace inivation {

using evt_words::append;
using evt_words::Bytes;
using Word = std::uint32_t;

inline Word time_stamp(std::uint32_t low) {
  return 0x8000 + low;
}
inline Word wrap(std::uint32_t times) {
  return 0x7000 + times;
}
inline Word special(std::uint32_t data) {
  return data;
}
inline Word time_reset() {
  return special(1);
}
inline Word imu_begin() {
  return special(5);
}
inline Word imu_end() {
  return special(7);
}
inline Word imu_byte(std::uint32_t byte) {
  return 0x5000 + byte;
}
inline Word imu_configuration(std::uint32_t data) {
  return 0x5300 + data;
}

// DAVIS
inline Word row(std::uint32_t y) {
  return 0x1000 + y;
}
inline Word column(std::uint32_t polarity, std::uint32_t x) {
  return (polarity == 0 ? 0x2000u : 0x3000u) + x;
}
inline Word frame_sample(std::uint32_t value) {
  return 0x4000 + value;
}

// DVXplorer
inline Word dvx_column(std::uint32_t x) {
  return 0x1000 + x;
}
inline Word dvx_rows(std::uint32_t first, std::uint32_t offset, bool subtract) {
  return 0x4000 + first + offset * 0x40 + (subtract ? 0x800u : 0u);
}
inline Word dvx_group(int group, std::uint32_t polarity, std::uint32_t mask) {
  return (group == 1 ? 0x3000u : 0x2000u) + (polarity == 0 ? 0x100u : 0u) + mask;
}

inline Bytes stream(std::initializer_list<Word> words) {
  Bytes bytes;
  for (const Word word : words) append(bytes, word, 2);
  return bytes;
}

/// One IMU sample: mark, configuration, the big-endian values, mark.
inline void append_imu(Bytes& bytes, std::uint32_t configuration, std::initializer_list<int> values) {
  append(bytes, imu_begin(), 2);
  append(bytes, imu_configuration(configuration), 2);
  for (const int value : values) {
    append(bytes, imu_byte((static_cast<unsigned>(value) >> 8) & 0xff), 2);
    append(bytes, imu_byte(static_cast<unsigned>(value) & 0xff), 2);
  }
  append(bytes, imu_end(), 2);
}

}  // namespace inivation
