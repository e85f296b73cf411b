// Where the events of a CSI frame end: the marker that a Prophesee sensor writes behind its last word. What
// lies behind it in the buffer is left over from earlier frames and decodes into plausible events.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "hal/evt_words.hpp"
#include "hal/raw_header.hpp"

namespace egofocus {

/// The marker as the format sees it: an OTHERS word of subtype 0x19. Sources:
/// prophesee-ai/rpi-sensor-drivers, openeb-for-rpi.patch (EVT3 word 0xE019; EVT2.1 mask 0xE00000FF00000000);
/// linux-sensor-drivers, imx636.rst (control end_of_frame_marker, by default 0xE019E019 twice, which stands
/// for EVT2 here). EVT2.1 needs the 64-bit marker: with its halves alike, the half that holds the type is
/// looked at in either order, so that no mask of pixels is taken for it.
class EvtFrameEnd {
 public:
  static constexpr std::size_t kNone = SIZE_MAX;

  explicit constexpr EvtFrameEnd(EvtFormat format) noexcept : format_(format) {}

  /// Bytes before the marker in `bytes`, which begin with a whole word; kNone without one. Thread: any. RT:
  /// yes, O(bytes).
  [[nodiscard]] std::size_t find(std::span<const std::byte> bytes) const noexcept {
    switch (format_) {
      case EvtFormat::kEvt2:
        return first<std::uint32_t>(bytes, 0xFFFFFFFF, 0xE019E019);
      case EvtFormat::kEvt21:
        return first<std::uint64_t>(bytes, 0xE00000FF00000000, 0xE000001900000000);
      case EvtFormat::kEvt21Legacy:
        return first<std::uint64_t>(bytes, 0x00000000E00000FF, 0x00000000E0000019);
      case EvtFormat::kEvt3:
        break;
    }
    return first<std::uint16_t>(bytes, 0xFFFF, 0xE019);
  }

  /// Copies what lies before the marker, or all without one, and reads at most kChunk bytes beyond that (a
  /// mapped buffer may be slow to read). Returns the bytes; `is_marked` says whether there was a marker.
  /// Precondition: `to` has room for `from`. Thread: any. RT: yes, O(bytes).
  std::size_t copy(std::span<const std::byte> from, std::span<std::byte> to, bool& is_marked) const noexcept {
    is_marked = false;
    for (std::size_t at = 0; at < from.size();) {
      const std::size_t bytes = from.size() - at < kChunk ? from.size() - at : kChunk;
      __builtin_memcpy(to.data() + at, from.data() + at, bytes);
      if (const std::size_t end = find(to.subspan(at, bytes)); end != kNone) {
        is_marked = true;
        return at + end;
      }
      at += bytes;
    }
    return from.size();
  }

 private:
  static constexpr std::size_t kChunk = 4096;  // whole words of every format

  template <typename Word>
  static std::size_t first(std::span<const std::byte> bytes, Word mask, Word marker) noexcept {
    WordReader<Word> words;
    Word word = 0;
    for (std::size_t at = 0; words.next(bytes, at, word);) {
      if (static_cast<Word>(word & mask) == marker) return at - sizeof(Word);
    }
    return kNone;
  }

  EvtFormat format_;
};

}  // namespace egofocus
