// RAW header: what parses is in range, and parses the same after it was written.
#include <cstring>

#include "fuzz/fuzz_input.hpp"
#include "hal/raw_header.hpp"

using namespace egofocus;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  RawHeader header;
  const Status status = parse_raw_header(std::as_bytes(std::span(data, size)), header);
  if (!status.ok()) {
    fuzz::require(status.value() >= 1);
    return 0;
  }
  fuzz::require(header.header_bytes > 0 && header.header_bytes <= size);
  fuzz::require(header.size.width_px >= 1 && header.size.width_px <= 2048);
  fuzz::require(header.size.height_px >= 1 && header.size.height_px <= 2048);
  fuzz::require(std::memchr(header.sensor_name, '\0', sizeof header.sensor_name) != nullptr);

  std::byte written[kMaxWrittenRawHeaderBytes];
  const std::size_t bytes = write_raw_header(header, written);
  fuzz::require(bytes > 0);
  RawHeader again;
  fuzz::require(parse_raw_header(std::span(written).first(bytes), again).ok());
  fuzz::require(again.format == header.format && again.header_bytes == bytes);
  fuzz::require(again.size.width_px == header.size.width_px && again.size.height_px == header.size.height_px);
  return 0;
}
