// Input: 16 bytes of settings, the text of a DBC, a NUL, then frames of 20 bytes. The roles are dealt to the
// signals in their order.
#include "fuzz/text_fuzz.hpp"
#include "hal/can_motion_decoder.hpp"

using namespace egofocus;
using fuzz::require;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 16) return 0;
  static Dbc dbc;
  static CanMotionDecoder decoder;
  const std::uint8_t* settings = data;
  const auto* text = reinterpret_cast<const char*>(data) + 16;
  const std::string_view rest(text, size - 16);
  std::size_t length = 0;
  while (length < rest.size() && rest[length] != '\0') ++length;
  if (!read_dbc({text, length}, {}, dbc).ok()) return 0;

  CanMotionConfig config;
  config.group_window_us = settings[0] * 100;
  config.stamp_last_frame = (settings[1] & 1) != 0;
  config.match_parameter_group = (settings[1] & 2) != 0;
  config.imu_delay_us = settings[2];
  for (int i = 0; i < 3; ++i) config.gyro_axes.from[i] = static_cast<std::int8_t>(settings[3 + i] % 7 - 3);
  if (settings[6] % 8 != 0) config.gyro_axes = {{-2, 3, 1}};
  unsigned role = settings[7];
  for (std::size_t m = 0; m < dbc.message_count; ++m) {
    const DbcMessage& message = dbc.messages[m];
    for (std::size_t s = 0; s < message.signal_count && config.signal_count < CanMotionConfig::kMaxSignals;
         ++s) {
      CanSignalRole& entry = config.signals[config.signal_count++];
      std::memcpy(entry.message, message.name, sizeof entry.message);
      std::memcpy(entry.signal, dbc.signals[message.first_signal + s].name, sizeof entry.signal);
      entry.role = static_cast<CanRole>(role++ % (kCanRoles + 1));
      entry.unit = static_cast<CanUnit>(settings[8] % 4);
      if ((settings[9] & 1) != 0) entry.raw_max = 0xFAFF;
    }
  }
  if (!decoder.configure(config, dbc).ok()) return 0;

  const std::uint8_t* frames = data + 16 + length;
  std::size_t left = size - 16 - length;
  MotionSamples out;
  std::uint64_t samples = 0;
  for (; left >= 20; left -= 20, frames += 20) {
    CanFrame frame;
    std::memcpy(&frame.t_us, frames, (frames[8] & 1) != 0 ? 8 : 3);
    frame.length = frames[9];
    const DbcMessage& message = dbc.messages[dbc.message_count == 0 ? 0 : frames[10] % dbc.message_count];
    frame.id = (frames[8] & 2) != 0 ? frames[11] : message.id;
    frame.extended = (frames[8] & 4) != 0 ? !message.extended : message.extended;
    for (std::size_t i = 0; i < 64; ++i) frame.data[i] = frames[12 + i % 8];
    decoder.feed(frame, out);
    require(out.imu_count <= 2 && out.odometry_count <= 2);
    samples += out.imu_count + out.odometry_count;
    for (std::size_t i = 0; i < out.imu_count; ++i) {
      require(out.imu[i].has_gyro != out.imu[i].has_accel);
      for (const double v : out.imu[i].gyro_rad_s) require(v - v == 0);
      for (const double v : out.imu[i].accel_m_s2) require(v - v == 0);
    }
  }
  const CanMotionCounters& n = decoder.counters();
  require(n.samples == samples && n.frames == n.frames_used + n.frames_unknown + n.frames_short);
  return 0;
}
