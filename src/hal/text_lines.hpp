// Cuts a stream of bytes into lines, for the decoders of text formats.
#pragma once

#include <cstddef>
#include <span>
#include <string_view>

#include "hal/decoded.hpp"

namespace egofocus {

/// Lines end with LF or CR LF. A line is cut only when it is whole, so nothing but one flag lives between
/// calls: a line that grows beyond the limit is skipped to its end, however long it is. Thread: one at a
/// time. RT: yes, O(bytes).
class TextLines {
 public:
  static constexpr std::size_t kMaxLineBytes = 512;  ///< without the LF

  enum class Kind {
    kLine,      ///< `line` is a whole line without its ending
    kPartial,   ///< no whole line is left: come again with these bytes and more
    kOverLong,  ///< a line beyond the limit begins here; told once a line
    kSkipped,   ///< more of that line
  };
  struct Cut {
    Kind kind = Kind::kPartial;
    std::size_t consumed = 0;  ///< above 0 unless kPartial
    std::string_view line;     ///< points into `bytes`
  };

  /// The first line of `bytes`. With `last`, the end of `bytes` ends a line too.
  Cut next(std::span<const std::byte> bytes, bool last) noexcept;

 private:
  bool skipping_ = false;
};

/// The loop of a decoder of lines: `decode_line(line, sample)` says whether the line gave a sample. Counts
/// `lines` and `over_long`; stops when `out` is full or no whole line is left. RT: yes, as decode_line is.
template <class Sample, class Counters, class DecodeLine>
Decoded decode_lines(TextLines& lines, std::span<const std::byte> bytes, std::span<Sample> out, bool last,
                     Counters& counters, DecodeLine decode_line) noexcept {
  Decoded done;
  while (done.produced < out.size()) {
    const TextLines::Cut cut = lines.next(bytes.subspan(done.consumed), last);
    if (cut.kind == TextLines::Kind::kPartial) break;
    done.consumed += cut.consumed;
    if (cut.kind == TextLines::Kind::kSkipped) continue;
    ++counters.lines;
    if (cut.kind == TextLines::Kind::kOverLong) {
      ++counters.over_long;
    } else if (decode_line(cut.line, out[done.produced])) {
      ++done.produced;
    }
  }
  return done;
}

}  // namespace egofocus
