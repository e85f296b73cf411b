// AEDAT 4.0 files: the header, the list of streams, packets of every compression.
#include "fuzz/fuzz_input.hpp"
#include "recording/aedat4_reader.hpp"
#include "recording/error.hpp"

using namespace egofocus;
using namespace egofocus::recording;

namespace {

void read_all(std::span<const std::byte> file) {
  Aedat4Reader reader(file, "fuzz");
  std::vector<Event> events;
  std::vector<Aedat4Imu> samples;
  std::size_t before = reader.position();
  fuzz::require(before <= reader.end() && reader.end() <= file.size());
  while (reader.next()) {
    fuzz::require(reader.position() >= before + 8 && reader.position() <= reader.end());
    fuzz::require(reader.type().size() == 4);
    before = reader.position();
    events.clear();
    samples.clear();
    reader.append_events(events);
    reader.append_imu(samples);
    fuzz::require(events.empty() || samples.empty());
    for (const Event& event : events)
      fuzz::require(event.polarity <= 1 && (event.x < 0x8000 || event.x == 65535));
  }
  fuzz::require(reader.position() == reader.end());
  fuzz::require(reader.cut_off_bytes() == 0 || reader.unclosed());
  fuzz::require(!reader.next());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::span<const std::byte> file = std::as_bytes(std::span(data, size));
  for (const Aedat4Stream& stream : parse_info_node({reinterpret_cast<const char*>(data), size})) {
    fuzz::require(stream.id >= 0 && !stream.type.empty());
  }
  try {
    read_all(file);
  } catch (const Error& error) {
    fuzz::require(error.exit_code() == static_cast<int>(ExitCode::kBadFile));
  }
  return 0;
}
