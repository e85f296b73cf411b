#include "hal/pose_text_decoder.hpp"

#include "core/decimal.hpp"
#include "core/elementary.hpp"
#include "hal/text_words.hpp"

namespace egofocus {
namespace {

bool take_number(std::string_view& line, double& value) noexcept {
  const std::string_view word = take_word(line);
  Decimal number;
  return !word.empty() && scan_decimal(word, number) == word.size() && to_double(number, value);
}

bool parse_pose(std::string_view line, PoseSample& pose) noexcept {
  const std::string_view time = take_word(line);
  Decimal seconds;
  if (scan_decimal(time, seconds) != time.size() || !to_microseconds(seconds, pose.t_us)) return false;
  for (double& p : pose.position_m) {
    if (!take_number(line, p)) return false;
  }
  for (double& q : pose.orientation_xyzw) {
    if (!take_number(line, q)) return false;
  }
  return take_word(line).empty();
}

// False unless the norm is 1 up to the rounding of hand-written files.
bool normalise(double (&q)[4]) noexcept {
  const double norm = square_root(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  if (!(norm >= 0.99 && norm <= 1.01)) return false;
  for (double& component : q) component /= norm;
  return true;
}

}  // namespace

bool PoseTextDecoder::decode_line(std::string_view line, PoseSample& pose) noexcept {
  std::string_view rest = line;
  const std::string_view first = take_word(rest);
  if (first.empty() || first.front() == '#') {
    ++counters_.blank;
    return false;
  }
  if (!parse_pose(line, pose)) {
    ++counters_.malformed;
    return false;
  }
  if (!normalise(pose.orientation_xyzw)) {
    ++counters_.bad_quaternion;
    return false;
  }
  ++counters_.poses;
  if (pose.t_us < latest_us_) {
    ++counters_.out_of_order;
  } else {
    latest_us_ = pose.t_us;
  }
  return true;
}

Decoded PoseTextDecoder::decode(std::span<const std::byte> bytes, std::span<PoseSample> out,
                                bool last) noexcept {
  return decode_lines(
      lines_, bytes, out, last, counters_,
      [this](std::string_view line, PoseSample& sample) noexcept { return decode_line(line, sample); });
}

Decoded PoseTextDecoder::feed(std::span<const std::byte> bytes, std::span<PoseSample> out) noexcept {
  return decode(bytes, out, false);
}

Decoded PoseTextDecoder::finish(std::span<const std::byte> bytes, std::span<PoseSample> out) noexcept {
  return decode(bytes, out, true);
}

}  // namespace egofocus
