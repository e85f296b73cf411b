#include "fuzz/text_fuzz.hpp"
#include "hal/candump_decoder.hpp"
#include "hal/candump_writer.hpp"

using namespace egofocus;
using fuzz::require;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto same = [](const CanFrame& a, const CanFrame& b) {
    return a.t_us == b.t_us && a.id == b.id && a.extended == b.extended && a.fd == b.fd &&
           a.length == b.length && std::memcmp(a.data, b.data, sizeof a.data) == 0;
  };
  fuzz::decode_text<CanFrame, CandumpDecoder>(
      data, size, same, [&](const std::vector<CanFrame>& frames, const CandumpCounters& n) {
        require(n.frames == frames.size());
        require(n.frames + n.error_frames + n.remote_frames + n.drop_notices + n.blank + n.unknown +
                    n.over_long ==
                n.lines);
        for (const CanFrame& frame : frames) {  // whatever was read can be written and read again
          char line[kMaxCandumpLineBytes];
          const std::size_t length = write_candump_line(frame, "can0", line);
          require(length > 0);
          CandumpDecoder again;
          CanFrame out[1];
          const Decoded done = again.feed(std::as_bytes(std::span(line, length)), out);
          require(done.consumed == length && done.produced == 1 && same(out[0], frame));
        }
      });
  return 0;
}
