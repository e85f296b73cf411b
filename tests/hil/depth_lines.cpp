// What the daemon gives, a line a frame, as `egofocus replay --golden` has it: time, hash, flags.
//
//   hil_depth SOCKET FRAMES [with-depth]      with-depth: counts and prints frames alone that measured depth
//
// Exit code: 0 all frames came, 4 the daemon ended before, 5 frames were missed.
#include <cinttypes>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "../../apps/egofocus/replay_report.hpp"
#include "egofocus/depth_reader.h"

using namespace egofocus;

namespace {

DepthFrame frame_of(const egofocus_depth_info& info, const std::vector<std::uint16_t>& inverse_depth,
                    const std::vector<std::uint8_t>& confidence) {
  DepthFrame frame;
  frame.t_us = info.t_us;
  frame.age_us = info.age_us;
  frame.votes = info.votes;
  frame.events = info.events;
  frame.flags = info.flags;
  frame.inverse_depth_scale_per_m = info.inverse_depth_scale_per_m;
  frame.parallax_px = info.parallax_px;
  for (int i = 0; i < 3; ++i) {
    frame.velocity_m_s[i] = info.velocity_m_s[i];
    frame.angular_rate_rad_s[i] = info.angular_rate_rad_s[i];
  }
  frame.inverse_depth = inverse_depth;
  frame.confidence = confidence;
  return frame;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fputs("usage: hil_depth SOCKET FRAMES [with-depth]\n", stderr);
    return 2;
  }
  egofocus_depth_reader reader;
  if (const int error = egofocus_depth_open(&reader, argv[1]); error != 0) {
    std::fprintf(stderr, "%s: error %d\n", argv[1], -error);
    return 3;
  }
  std::vector<std::uint16_t> inverse_depth(egofocus_depth_pixels(&reader));
  std::vector<std::uint8_t> confidence(inverse_depth.size());
  egofocus_depth_info info;
  int left = std::atoi(argv[2]);
  while (left > 0) {
    if (egofocus_depth_wait(&reader, 1000) < 0) return 4;
    while (left > 0 && egofocus_depth_next(&reader, &info, inverse_depth.data(), confidence.data()) == 1) {
      if (argc > 3 && (info.hypotheses == 0 || (info.flags & kCarried) != 0)) continue;
      const DepthFrame frame = frame_of(info, inverse_depth, confidence);
      std::printf("t_us %" PRId64 " hash %016" PRIx64 " flags %s latency_ms %" PRId64 "\n", frame.t_us,
                  app::frame_hash(frame), app::flags_text(frame.flags).c_str(), info.latency_us / 1000);
      std::fflush(stdout);
      --left;
    }
  }
  return reader.missed == 0 ? 0 : 5;
}
