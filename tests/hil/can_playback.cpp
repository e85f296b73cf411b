// A recorded bus, played at the speed of its recording, gives the samples that the log gives.
#include <fstream>
#include <iterator>

#include "hal/candump_decoder.hpp"
#include "hil/can_bench.hpp"

using namespace egofocus;
using namespace egofocus::hil;

namespace {

std::string text_of_file(const char* name) {
  std::ifstream file(name, std::ios::binary);
  REQUIRE(file.good());
  return {std::istreambuf_iterator<char>(file), {}};
}

CanMotionConfig planes_motion() {
  CanMotionConfig config;
  config.group_window_us = 2000;
  const char* axes[3] = {"GyroX", "GyroY", "GyroZ"};
  for (int i = 0; i < 3; ++i)
    add_role(config, "IMU_RATE", axes[i], static_cast<CanRole>(static_cast<int>(CanRole::kGyroX) + i));
  return config;
}

std::vector<ImuSample> samples_of_log(const std::string& dbc_text, const std::string& log) {
  static Dbc dbc;
  static CanMotionDecoder motion;
  REQUIRE(read_dbc(dbc_text, {}, dbc).ok() && motion.configure(planes_motion(), dbc).ok());
  CandumpDecoder decoder;
  std::vector<CanFrame> frames(log.size() / 20 + 1);
  const Decoded done = decoder.feed(std::as_bytes(std::span(log)), frames);
  REQUIRE(done.consumed == log.size());
  std::vector<ImuSample> result;
  MotionSamples out;
  for (std::size_t i = 0; i < done.produced; ++i) {
    motion.feed(frames[i], out);
    result.insert(result.end(), out.imu, out.imu + out.imu_count);
  }
  return result;
}

}  // namespace

int main() {
  const std::string dbc = text_of_file("vehicle.dbc");
  const std::vector<ImuSample> expected = samples_of_log(dbc, text_of_file("can.log"));
  REQUIRE(expected.size() > 400);
  Bench bench(config_of("vcan0"), dbc, planes_motion());
  REQUIRE(bench.source.start().ok());
  shell("hil_play_can can.log vcan0 &");
  std::vector<ImuSample> got;
  for (std::int64_t last_us = now_us(); got.size() < expected.size() && now_us() - last_us < 60'000'000;) {
    bench.poll_for(1);
    for (const ImuSample& sample : bench.imu()) {
      got.push_back(sample);
      last_us = now_us();
    }
  }
  const SocketCanHealth health = bench.health();
  std::printf("       %zu samples of %zu; %llu frames, %llu of other ids, %llu lost by the socket\n",
              got.size(), expected.size(), static_cast<unsigned long long>(health.frames),
              static_cast<unsigned long long>(health.motion.frames_unknown),
              static_cast<unsigned long long>(health.kernel_dropped));
  REQUIRE(got.size() == expected.size());
  bool same = true, rising = true;
  for (std::size_t i = 0; i < got.size(); ++i) {
    for (int k = 0; k < 3; ++k) same = same && got[i].gyro_rad_s[k] == expected[i].gyro_rad_s[k];
    rising = rising && (i == 0 || got[i].t_us > got[i - 1].t_us);
  }
  EXPECT(same);
  EXPECT(rising);
  EXPECT(bench.health().kernel_dropped == 0);
  EXPECT(bench.health().motion.frames_unknown == 0);
  // The player may be late, never early: nothing is shorter than it was recorded.
  EXPECT(got.back().t_us - got.front().t_us >= expected.back().t_us - expected.front().t_us - 50000);
  return failures != 0;
}
