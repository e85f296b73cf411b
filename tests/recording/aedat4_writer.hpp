// Writes AEDAT 4.0 files for the tests, byte by byte after the format's description: FlatBuffers laid out by
// hand, in the order that iniVation's own writer has (root table first, its vtable before it).
#pragma once

#include <lz4frame.h>
#include <zstd.h>

#include <bit>
#include <cstdint>
#include <string>
#include <vector>

#include "egofocus/types.hpp"

namespace egofocus::test {

class ByteWriter {
 public:
  ByteWriter& number(std::uint64_t value, int bytes) {
    for (int i = 0; i < bytes; ++i) data.push_back(static_cast<char>(value >> (8 * i)));
    return *this;
  }
  ByteWriter& u16(std::uint64_t value) { return number(value, 2); }
  ByteWriter& u32(std::uint64_t value) { return number(value, 4); }
  ByteWriter& i64(std::int64_t value) { return number(static_cast<std::uint64_t>(value), 8); }
  ByteWriter& real(float value) { return u32(std::bit_cast<std::uint32_t>(value)); }
  ByteWriter& text(const std::string& value) {
    data += value;
    return *this;
  }
  std::string data;
};

inline std::string with_size(const std::string& bytes) {
  return ByteWriter().u32(bytes.size()).text(bytes).data;
}

/// A packet's root: one field, a vector that follows directly.
inline ByteWriter packet_root(const char* identifier, std::size_t count) {
  ByteWriter out;
  out.u32(16).text(identifier);     // the root table is at 16
  out.u16(0).u16(6).u16(8).u16(4);  // padding, then the vtable at 10: its size, the table's, field 0
  out.u32(6).u32(4);                // the table: back to the vtable; the vector is 4 bytes on
  out.u32(count);
  return out;
}

inline std::string events_packet(const std::vector<Event>& events) {
  ByteWriter out = packet_root("EVTS", events.size());
  for (const Event& event : events)
    out.i64(event.t_us).u16(event.x).u16(event.y).number(event.polarity, 1).number(0, 3);
  return out.data;
}

struct WrittenImu {
  std::int64_t t_us;
  float accel[3];
  float gyro[3];
};

/// The tables share one vtable, at the end; what is zero is left out of the last sample, as a writer may.
inline std::string imu_packet(const std::vector<WrittenImu>& samples) {
  constexpr std::size_t kTableBytes = 40;
  ByteWriter out = packet_root("IMUS", samples.size());
  const std::size_t first = out.data.size() + 4 * samples.size();
  for (std::size_t i = 0; i < samples.size(); ++i) out.u32(first + i * kTableBytes - out.data.size());
  const std::size_t vtable = first + samples.size() * kTableBytes;
  for (const WrittenImu& sample : samples) {
    out.u32(static_cast<std::uint32_t>(out.data.size() - vtable)).real(25.0f);
    for (const float value : sample.accel) out.real(value);
    for (const float value : sample.gyro) out.real(value);
    out.i64(sample.t_us);
  }
  out.u16(20).u16(kTableBytes).u16(32).u16(4);  // size, table size, timestamp, temperature
  for (const int offset : {8, 12, 16, 20, 24, 28}) out.u16(static_cast<std::uint64_t>(offset));
  return out.data;
}

inline std::string pack_lz4(const std::string& bytes) {
  std::string packed(LZ4F_compressFrameBound(bytes.size(), nullptr), '\0');
  packed.resize(LZ4F_compressFrame(packed.data(), packed.size(), bytes.data(), bytes.size(), nullptr));
  return packed;
}

inline std::string pack_zstd(const std::string& bytes) {
  std::string packed(ZSTD_compressBound(bytes.size()), '\0');
  packed.resize(ZSTD_compress(packed.data(), packed.size(), bytes.data(), bytes.size(), 1));
  return packed;
}

/// Compression as the header names it: 0 none, 1 and 2 LZ4, 3 and 4 Zstandard.
class Aedat4Writer {
 public:
  Aedat4Writer(int compression, int width_px, int height_px) : compression_(compression) {
    info_ = "<dv version=\"2.0\"><node name=\"outInfo\" path=\"/outInfo/\">" +
            stream(0, "EVTS", width_px, height_px) + stream(1, "IMUS", 0, 0) + stream(2, "TRIG", 0, 0) +
            "</node></dv>\n";
  }

  void packet(int stream, const std::string& buffer) {
    const std::string sized = with_size(buffer);
    const std::string packed = compression_ == 0   ? sized
                               : compression_ <= 2 ? pack_lz4(sized)
                                                   : pack_zstd(sized);
    packets_ += ByteWriter().u32(static_cast<std::uint64_t>(stream)).u32(packed.size()).text(packed).data;
  }

  /// `closed`: the header says where the table is. Else -1, and no table.
  [[nodiscard]] std::string file(bool closed = true) const {
    const std::string magic = "#!AER-DAT4.0\r\n";
    const std::size_t header_bytes = header(0).size();
    const std::int64_t table = static_cast<std::int64_t>(magic.size() + header_bytes + packets_.size());
    return magic + header(closed ? table : -1) + packets_ + (closed ? "the table" : "");
  }

 private:
  static std::string stream(int id, const std::string& type, int width_px, int height_px) {
    std::string text = "<node name=\"" + std::to_string(id) +
                       "\" path=\"/outInfo/\"><attr key=\"typeIdentifier\" type=\"string\">" + type +
                       "</attr><node name=\"info\" path=\"/\">";
    if (width_px > 0) {
      text += "<attr key=\"sizeX\" type=\"int\">" + std::to_string(width_px) +
              "</attr><attr key=\"sizeY\" type=\"int\">" + std::to_string(height_px) + "</attr>";
    }
    return text + "</node></node>";
  }

  [[nodiscard]] std::string header(std::int64_t table) const {
    ByteWriter out;
    out.u32(20).text("IOHE");
    out.u16(0).u16(10).u16(20).u16(4).u16(8).u16(16);  // vtable at 10: three fields
    out.u32(10).u32(static_cast<std::uint64_t>(compression_)).i64(table).u32(4);
    out.u32(info_.size()).text(info_);
    return with_size(out.data);
  }

  int compression_;
  std::string info_;
  std::string packets_;
};

}  // namespace egofocus::test
