// Words of the three EVT formats, built field by field from their layouts; nothing is shared with the
// library.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "egofocus/types.hpp"
#include "hal/decoded.hpp"

namespace evt_words {

using Bytes = std::vector<std::byte>;

inline void append(Bytes& bytes, std::uint64_t word, int size) {
  for (int i = 0; i < size; ++i) bytes.push_back(static_cast<std::byte>(word >> (8 * i)));
}

namespace evt2 {
using Word = std::uint32_t;
inline Word time_high(std::uint32_t counter) {
  return 0x80000000u + counter;
}
inline Word cd(std::uint32_t polarity, std::uint32_t low, std::uint32_t x, std::uint32_t y) {
  return polarity * 0x10000000u + low * 0x400000u + x * 0x800u + y;
}
inline Word trigger(std::uint32_t low, std::uint32_t id, std::uint32_t value) {
  return 0xA0000000u + low * 0x400000u + id * 0x100u + value;
}
inline Word other(std::uint32_t subtype) {
  return 0xE0000000u + subtype;
}
inline Word continued(std::uint32_t payload) {
  return 0xF0000000u + payload;
}
inline Bytes stream(std::initializer_list<Word> words) {
  Bytes bytes;
  for (const Word word : words) append(bytes, word, 4);
  return bytes;
}
}  // namespace evt2

namespace evt21 {
struct Word {
  std::uint32_t upper;
  std::uint32_t lower;
};
inline Word time_high(std::uint32_t counter) {
  return {0x80000000u + counter, 0};
}
inline Word cd(std::uint32_t polarity, std::uint32_t low, std::uint32_t x, std::uint32_t y,
               std::uint32_t mask) {
  return {evt2::cd(polarity, low, x, y), mask};
}
inline Word trigger(std::uint32_t low, std::uint32_t id, std::uint32_t value) {
  return {evt2::trigger(low, id, value), 0};
}
inline Word others(std::uint32_t subtype, std::uint32_t payload) {
  return {0xE0000000u + subtype, payload};
}
inline Bytes stream(std::initializer_list<Word> words, bool legacy = false) {
  Bytes bytes;
  for (const Word& word : words) {
    append(bytes, legacy ? word.upper : word.lower, 4);
    append(bytes, legacy ? word.lower : word.upper, 4);
  }
  return bytes;
}
}  // namespace evt21

namespace evt3 {
using Word = std::uint32_t;
inline Word addr_y(std::uint32_t y) {
  return y;
}
inline Word addr_x(std::uint32_t polarity, std::uint32_t x) {
  return 0x2000 + polarity * 0x800 + x;
}
inline Word base_x(std::uint32_t polarity, std::uint32_t x) {
  return 0x3000 + polarity * 0x800 + x;
}
inline Word vect12(std::uint32_t mask) {
  return 0x4000 + mask;
}
inline Word vect8(std::uint32_t mask) {
  return 0x5000 + mask;
}
inline Word time_low(std::uint32_t low) {
  return 0x6000 + low;
}
inline Word continued4(std::uint32_t payload) {
  return 0x7000 + payload;
}
inline Word time_high(std::uint32_t counter) {
  return 0x8000 + counter;
}
inline Word trigger(std::uint32_t id, std::uint32_t value) {
  return 0xA000 + id * 0x100 + value;
}
inline Word others(std::uint32_t subtype) {
  return 0xE000 + subtype;
}
inline Word continued12(std::uint32_t payload) {
  return 0xF000 + payload;
}
inline Bytes stream(std::initializer_list<Word> words) {
  Bytes bytes;
  for (const Word word : words) append(bytes, word, 2);
  return bytes;
}
}  // namespace evt3

/// All events of `bytes`, with `room` places of output per call and input cut after every `cut` bytes.
template <typename Decoder>
std::vector<egofocus::Event> decode(Decoder& decoder, std::span<const std::byte> bytes, std::size_t room = 64,
                                    std::size_t cut = SIZE_MAX) {
  std::vector<egofocus::Event> events;
  std::vector<egofocus::Event> out(room);
  for (;;) {
    const egofocus::Decoded done = decoder.feed(bytes.first(bytes.size() < cut ? bytes.size() : cut), out);
    events.insert(events.end(), out.begin(), out.begin() + static_cast<std::ptrdiff_t>(done.produced));
    bytes = bytes.subspan(done.consumed);
    if (bytes.empty() && done.produced < room) return events;
  }
}

}  // namespace evt_words
