// Little-endian words of 16, 32 or 64 bits, cut out of byte spans that may end anywhere.
#pragma once

#include <cstddef>
#include <span>

namespace egofocus {

template <typename Word>
class WordReader {
 public:
  /// The next whole word of `bytes` from `at` on, which moves past all that was taken. False when the bytes
  /// end first: they were taken all the same and wait here for their rest. Thread: one. RT: yes.
  bool next(std::span<const std::byte> bytes, std::size_t& at, Word& word) noexcept {
    if (held_ == 0 && bytes.size() - at >= sizeof(Word)) {
      word = 0;
      for (std::size_t i = 0; i < sizeof(Word); ++i) word = append(word, bytes[at + i], i);
      at += sizeof(Word);
      return true;
    }
    while (at < bytes.size()) {
      partial_ = append(partial_, bytes[at++], held_++);
      if (held_ == sizeof(Word)) {
        word = partial_;
        partial_ = 0;
        held_ = 0;
        return true;
      }
    }
    return false;
  }

  /// Forgets the bytes of a word that is not complete; returns how many there were. Thread: one. RT: yes.
  std::size_t drop_partial() noexcept {
    const std::size_t dropped = held_;
    partial_ = 0;
    held_ = 0;
    return dropped;
  }

 private:
  static Word append(Word word, std::byte byte, std::size_t index) noexcept {
    return static_cast<Word>(word | static_cast<Word>(static_cast<Word>(byte) << (8 * index)));
  }

  Word partial_ = 0;
  std::size_t held_ = 0;
};

/// Writes `word` at `at`, which moves behind it. Precondition: there is room. Thread: any. RT: yes.
template <typename Word>
void write_word(Word word, std::span<std::byte> bytes, std::size_t& at) noexcept {
  for (std::size_t i = 0; i < sizeof(Word); ++i)
    bytes[at++] = static_cast<std::byte>((word >> (8 * i)) & 0xff);
}

}  // namespace egofocus
