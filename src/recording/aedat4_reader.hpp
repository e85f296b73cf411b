// AEDAT 4.0, what iniVation's DV writes: a header, then packets of one stream each.
//
//   "#!AER-DAT4.0\r\n"
//   u32 size, FlatBuffer IOHE: compression (i32), position of the table at the end (i64, -1: never written),
//                              infoNode (XML: the streams)
//   packets: i32 stream, i32 size, `size` bytes: a compressed FlatBuffer with its own u32 size in front
//   the table (FTAB), which this reader only uses to know where the packets end
//
// Source: inivation's "AEDAT file formats", AEDAT 4.0, and dv-processing's schemas (ioheader, events, imus).
// Bytes are not trusted. Errors are Error(kBadFile) with the position.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "egofocus/types.hpp"
#include "recording/packet_compression.hpp"

namespace egofocus::recording {

struct Aedat4Stream {
  std::int32_t id = -1;
  std::string type;           ///< "EVTS", "IMUS", "FRME", "TRIG"
  std::int32_t width_px = 0;  ///< 0: not said
  std::int32_t height_px = 0;
};

/// Accelerometer in g, gyro in deg/s, as the file has them.
struct Aedat4Imu {
  std::int64_t t_us = 0;
  float accel_g[3] = {0, 0, 0};
  float gyro_deg_s[3] = {0, 0, 0};
};

class Aedat4Reader {
 public:
  /// Reads the header. `file` must outlive the reader; `name` is for messages.
  Aedat4Reader(std::span<const std::byte> file, std::string name);

  [[nodiscard]] const std::vector<Aedat4Stream>& streams() const { return streams_; }

  /// The next packet, unpacked into stream() and type(); false at the end. Throws when one is damaged, or
  /// when the file ends before the place that its header names.
  bool next();

  [[nodiscard]] std::int32_t stream() const { return stream_; }
  [[nodiscard]] std::string_view type() const { return type_; }

  /// Appends what the packet holds; nothing for packets of another type. x or y below 0 becomes 65535.
  /// Throws.
  void append_events(std::vector<Event>& events) const;
  void append_imu(std::vector<Aedat4Imu>& samples) const;

  /// Where the next packet begins, and where the packets end.
  [[nodiscard]] std::size_t position() const { return position_; }
  [[nodiscard]] std::size_t end() const { return end_; }
  /// The recorder never closed the file: there is no table, and the last packet may be cut off.
  [[nodiscard]] bool unclosed() const { return unclosed_; }
  /// Bytes of a last packet that is cut off in such a file.
  [[nodiscard]] std::size_t cut_off_bytes() const { return cut_off_bytes_; }

 private:
  void read_header();
  [[nodiscard]] std::string where(std::size_t position) const;

  std::span<const std::byte> file_;
  std::string name_;
  Compression compression_ = Compression::kNone;
  std::vector<Aedat4Stream> streams_;
  std::size_t position_ = 0;
  std::size_t end_ = 0;
  bool unclosed_ = false;
  std::size_t cut_off_bytes_ = 0;
  std::size_t packet_position_ = 0;
  std::int32_t stream_ = -1;
  std::string type_;
  std::vector<std::byte> packet_;
};

/// The streams that an infoNode lists; what is no stream is left out.
[[nodiscard]] std::vector<Aedat4Stream> parse_info_node(std::string_view xml);

/// Does the file begin as AEDAT 4 files do?
[[nodiscard]] bool is_aedat4(std::string_view file);

}  // namespace egofocus::recording
