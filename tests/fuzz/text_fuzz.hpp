// What holds for every decoder of text lines: cut anywhere, the same items and counters come out.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "hal/decoded.hpp"

namespace egofocus::fuzz {

inline void require(bool condition) {
  if (!condition) __builtin_trap();
}

template <typename Item, typename Decoder>
std::vector<Item> decode_in_pieces(Decoder& decoder, std::span<const std::byte> bytes, std::size_t piece,
                                   std::size_t room) {
  std::vector<Item> items;
  std::vector<Item> out(room);
  std::size_t at = 0;
  std::size_t end = 0;
  while (at < bytes.size()) {
    const bool last = end == bytes.size();
    const auto part = bytes.subspan(at, end - at);
    const Decoded done = last ? decoder.finish(part, out) : decoder.feed(part, out);
    require(done.consumed <= part.size() && done.produced <= room);
    require(!last || done.consumed > 0);  // the end is always reached
    items.insert(items.end(), out.begin(), out.begin() + static_cast<std::ptrdiff_t>(done.produced));
    at += done.consumed;
    if (done.consumed == 0) end = bytes.size() - end > piece ? end + piece : bytes.size();
  }
  return items;
}

/// The first byte of the input says how to cut the rest.
template <typename Item, typename Decoder, typename Same, typename Check>
void decode_text(const std::uint8_t* data, std::size_t size, Same same, Check check) {
  if (size == 0) return;
  const auto bytes = std::as_bytes(std::span(data + 1, size - 1));
  Decoder whole;
  Decoder cut;
  const auto items = decode_in_pieces<Item>(whole, bytes, bytes.size(), 64);
  const auto others =
      decode_in_pieces<Item>(cut, bytes, data[0] % 64 + std::size_t{1}, data[0] / 64 + std::size_t{1});
  require(items.size() == others.size());
  for (std::size_t i = 0; i < items.size(); ++i) require(same(items[i], others[i]));
  require(std::memcmp(&whole.counters(), &cut.counters(), sizeof whole.counters()) == 0);
  check(items, whole.counters());
}

}  // namespace egofocus::fuzz
