#include "recording/raw_file.hpp"

#include "hal/evt3_encoder.hpp"
#include "hal/raw_header.hpp"
#include "recording/error.hpp"
#include "recording/text_file.hpp"

namespace egofocus::recording {

std::vector<std::byte> raw_file_bytes(std::span<const Event> events, SensorSize size) {
  RawHeader header;
  header.format = EvtFormat::kEvt3;
  header.size = size;
  std::vector<std::byte> bytes(kMaxWrittenRawHeaderBytes);
  bytes.resize(write_raw_header(header, bytes));

  Evt3Encoder encoder;
  std::vector<std::byte> block(1u << 16);
  std::size_t done = 0;
  while (done < events.size()) {
    const Decoded step = encoder.encode(events.subspan(done), block);
    if (step.consumed == 0 && step.produced == 0) break;
    bytes.insert(bytes.end(), block.begin(), block.begin() + static_cast<std::ptrdiff_t>(step.produced));
    done += step.consumed;
  }
  if (done != events.size())
    throw Error(ExitCode::kInternal, "events.raw", "the encoder stopped before the last event.");
  return bytes;
}

void write_raw_file(const std::filesystem::path& path, std::span<const Event> events, SensorSize size) {
  const std::vector<std::byte> bytes = raw_file_bytes(events, size);
  write_text_file(path, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

}  // namespace egofocus::recording
