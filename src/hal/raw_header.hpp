// The ASCII header of Prophesee RAW files: lines "% key value", closed by "% end" (old files: by the first
// line that does not begin with "% ").
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "egofocus/status.hpp"
#include "hal/sensor_size.hpp"

namespace egofocus {

enum class EvtFormat : std::uint8_t { kEvt2, kEvt21, kEvt21Legacy, kEvt3 };

/// A word of the format: a file that ends inside one was cut off. Thread: any. RT: yes.
constexpr std::size_t word_bytes(EvtFormat format) noexcept {
  return format == EvtFormat::kEvt3 ? 2 : (format == EvtFormat::kEvt2 ? 4 : 8);
}

/// "EVT2", "EVT2.1", "EVT2.1 (legacy order)", "EVT3". Thread: any. RT: yes.
const char* to_string(EvtFormat format) noexcept;

/// What a decoder and a report need. Texts end with NUL and are cut to fit.
struct RawHeader {
  EvtFormat format = EvtFormat::kEvt3;
  SensorSize size;
  char sensor_name[32] = {};
  char serial_number[32] = {};
  char date[32] = {};
  std::size_t header_bytes = 0;  ///< the words begin here
};

/// Reads the header at the beginning of `file`, whose bytes are not trusted. Precedence: `format` over `evt`,
/// its height and width over `geometry`, that over the sensor's name or generation; EVT 2.1 that names no
/// endianness is in legacy order. Source: facts, C1. Errors, with the line from 1 in value(): kBadHeader: no
/// header, a number or line that cannot be, no format, no geometry; kUnsupportedFormat: another format.
/// Thread: any. RT: no, set-up.
Status parse_raw_header(std::span<const std::byte> file, RawHeader& header) noexcept;

/// Writes the header that parse_raw_header() reads back (header_bytes is not looked at; empty texts are left
/// out). Returns its bytes, or 0 if `out` is too small; kMaxWrittenRawHeaderBytes always suffices. Thread:
/// any. RT: no, set-up.
std::size_t write_raw_header(const RawHeader& header, std::span<std::byte> out) noexcept;
inline constexpr std::size_t kMaxWrittenRawHeaderBytes = 320;

}  // namespace egofocus
