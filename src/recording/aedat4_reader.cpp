#include "recording/aedat4_reader.hpp"

#include <utility>

#include "recording/error.hpp"
#include "recording/flat_buffer.hpp"

namespace egofocus::recording {
namespace {

constexpr std::string_view kMagic = "#!AER-DAT4.0\r\n";
constexpr std::size_t kPacketHeaderBytes = 8;
constexpr std::size_t kEventBytes = 16;
// IMU: timestamp, temperature, accelerometer x y z, gyro x y z, magnetometer x y z.
constexpr std::size_t kImuAccel = 2;
constexpr std::size_t kImuGyro = 5;

/// A buffer behind its own u32 size.
std::span<const std::byte> sized(std::span<const std::byte> bytes) {
  const FlatBuffer prefix(bytes);
  return prefix.part(4, prefix.u32_at(0));
}

std::uint16_t pixel(std::uint16_t raw) {
  return raw < 0x8000 ? raw : std::uint16_t{65535};
}

}  // namespace

bool is_aedat4(std::string_view file) {
  return file.substr(0, kMagic.size()) == kMagic;
}

Aedat4Reader::Aedat4Reader(std::span<const std::byte> file, std::string name)
    : file_(file), name_(std::move(name)) {
  if (!is_aedat4({reinterpret_cast<const char*>(file_.data()), file_.size()})) {
    throw Error(
        ExitCode::kBadFile, name_,
        "is no AEDAT 4.0 file: it does not begin with `#!AER-DAT4.0`. Older AEDAT files must be converted "
        "with DV first.");
  }
  try {
    read_header();
  } catch (const OutOfBuffer&) {
    throw Error(ExitCode::kBadFile, name_,
                "is cut off or damaged within its header. Copy or record it again.");
  }
}

std::string Aedat4Reader::where(std::size_t position) const {
  return name_ + ": byte " + std::to_string(position);
}

void Aedat4Reader::read_header() {
  const std::span<const std::byte> bytes = sized(file_.subspan(kMagic.size()));
  const FlatBuffer header(bytes);
  if (header.identifier() != "IOHE") throw OutOfBuffer();
  const std::size_t root = header.root();
  if (const auto at = header.field(root, 0)) {
    const std::int32_t compression = header.i32_at(*at);
    if (compression < 0 || compression > static_cast<std::int32_t>(Compression::kZstdHigh)) {
      throw Error(ExitCode::kBadFile, name_,
                  "names compression " + std::to_string(compression) + ", which is not known.");
    }
    compression_ = static_cast<Compression>(compression);
  }
  const auto table_at = header.field(root, 1);
  const std::int64_t table = table_at ? header.i64_at(*table_at) : -1;
  if (const auto at = header.field(root, 2)) streams_ = parse_info_node(header.text(*at));
  position_ = kMagic.size() + 4 + bytes.size();
  unclosed_ = table < 0;
  end_ = unclosed_ ? file_.size() : static_cast<std::size_t>(table);
  if (!unclosed_ && (static_cast<std::uint64_t>(table) > file_.size() || end_ < position_)) {
    throw Error(ExitCode::kBadFile, name_,
                "has " + std::to_string(file_.size()) + " bytes, but its packets end at " +
                    std::to_string(table) + ": the file is truncated. Copy it again.");
  }
}

bool Aedat4Reader::next() {
  packet_position_ = position_;
  if (position_ == end_) return false;
  const FlatBuffer all(file_.first(end_));
  std::span<const std::byte> packed;
  try {
    stream_ = all.i32_at(position_);
    const std::int32_t size = all.i32_at(position_ + 4);
    if (size < 0)
      throw Error(ExitCode::kBadFile, where(position_),
                  "a packet has a size below zero: the file is damaged.");
    packed = all.part(position_ + kPacketHeaderBytes, static_cast<std::size_t>(size));
  } catch (const OutOfBuffer&) {
    if (!unclosed_)
      throw Error(ExitCode::kBadFile, where(position_),
                  "a packet reaches beyond the end: the file is damaged.");
    cut_off_bytes_ = end_ - position_;
    position_ = end_;
    return false;
  }
  unpack(compression_, packed, where(position_), packet_);
  position_ += kPacketHeaderBytes + packed.size();
  try {
    type_ = FlatBuffer(sized(packet_)).identifier();
  } catch (const OutOfBuffer&) {
    throw Error(ExitCode::kBadFile, where(packet_position_),
                "a packet is no FlatBuffer: the file is damaged.");
  }
  return true;
}

void Aedat4Reader::append_events(std::vector<Event>& events) const {
  if (type_ != "EVTS") return;
  try {
    const FlatBuffer buffer(sized(packet_));
    const auto elements = buffer.field(buffer.root(), 0);
    if (!elements) return;
    const FlatBuffer::Vector rows = buffer.vector(*elements, kEventBytes);
    for (std::size_t i = 0; i < rows.count; ++i) {
      const std::size_t at = rows.first + i * kEventBytes;
      events.push_back({buffer.i64_at(at), pixel(buffer.u16_at(at + 8)), pixel(buffer.u16_at(at + 10)),
                        static_cast<std::uint8_t>(buffer.unsigned_at(at + 12, 1) != 0 ? 1 : 0)});
    }
  } catch (const OutOfBuffer& error) {
    throw Error(ExitCode::kBadFile, where(packet_position_),
                std::string("a packet of events is damaged: ") + error.what() + ".");
  }
}

void Aedat4Reader::append_imu(std::vector<Aedat4Imu>& samples) const {
  if (type_ != "IMUS") return;
  try {
    const FlatBuffer buffer(sized(packet_));
    const auto elements = buffer.field(buffer.root(), 0);
    if (!elements) return;
    const FlatBuffer::Vector rows = buffer.vector(*elements, 4);
    for (std::size_t i = 0; i < rows.count; ++i) {
      const std::size_t table = buffer.follow(rows.first + 4 * i);
      const auto number = [&](std::size_t index) {
        const auto at = buffer.field(table, index);
        return at ? buffer.float_at(*at) : 0.0f;
      };
      Aedat4Imu sample;
      if (const auto at = buffer.field(table, 0)) sample.t_us = buffer.i64_at(*at);
      for (std::size_t k = 0; k < 3; ++k) {
        sample.accel_g[k] = number(kImuAccel + k);
        sample.gyro_deg_s[k] = number(kImuGyro + k);
      }
      samples.push_back(sample);
    }
  } catch (const OutOfBuffer& error) {
    throw Error(ExitCode::kBadFile, where(packet_position_),
                std::string("a packet of IMU samples is damaged: ") + error.what() + ".");
  }
}

}  // namespace egofocus::recording
