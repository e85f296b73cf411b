// A camera that is turned to and fro in a simulated room, its IMU late by a known time.
#include "recording/time_offset.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

#include "recording/error.hpp"
#include "recording/raw_file.hpp"
#include "support/plane_simulator.hpp"
#include "support/planes_recording.hpp"
#include "support/source_dir.hpp"

using namespace egofocus;
using namespace egofocus::recording;
namespace fs = std::filesystem;

namespace {

// Turns of various lengths about all axes while the camera drifts sideways: what a hand does in three
// seconds.
std::vector<sim::Phase> turns() {
  std::vector<sim::Phase> phases;
  const double rates[][3] = {{0, 1.2, 0},     {0, -1.2, 0.6},  {0.9, 0, -0.6},
                             {-0.9, -1.0, 0}, {0.5, 1.0, 1.0}, {-0.5, 0, -1.0}};
  const std::int64_t durations_us[] = {180000, 220000, 200000, 160000, 240000};
  for (std::size_t i = 0; i < 15; ++i) {
    const double* r = rates[i % 6];
    phases.push_back({durations_us[i % 5], {{i % 2 == 0 ? 0.3 : -0.3, 0, 0}, {r[0], r[1], r[2]}}});
  }
  return phases;
}

class TurnedCamera {
 public:
  TurnedCamera() : path_(fs::temp_directory_path() / "egofocus_time_offset_test"), simulator_(3, turns()) {
    fs::remove_all(path_);
    fs::create_directories(path_);
    const std::vector<Event> events = simulator_.events();
    const Intrinsics& camera = simulator_.camera().config.camera.intrinsics;
    write_raw_file(
        path_ / "events.raw", events,
        {static_cast<std::uint16_t>(camera.width_px), static_cast<std::uint16_t>(camera.height_px)});
    for (const auto& [name, text] : sim::planes_texts(simulator_)) put(name, text);
    log_ = sim::planes_texts(simulator_).at("can.log");
  }
  ~TurnedCamera() { fs::remove_all(path_); }
  TurnedCamera(const TurnedCamera&) = delete;
  TurnedCamera& operator=(const TurnedCamera&) = delete;

  // With every frame of the bus this much later.
  Folder open(std::int64_t late_us) {
    std::string moved;
    for (std::size_t at = 0; at < log_.size();) {
      const std::size_t end = log_.find('\n', at);
      const std::string line = log_.substr(at, end - at);
      const std::size_t dot = line.find('.');
      const std::int64_t t_us =
          std::stoll(line.substr(1, dot - 1)) * 1000000 + std::stoll(line.substr(dot + 1, 6)) + late_us;
      if (t_us >= 0) {
        char time[48];
        std::snprintf(time, sizeof time, "(%lld.%06lld)", static_cast<long long>(t_us / 1000000),
                      static_cast<long long>(t_us % 1000000));
        moved += time + line.substr(line.find(')') + 1) + "\n";
      }
      at = end + 1;
    }
    put("can.log", moved);
    return open_folder(path_, MotionSource::kOdometry);
  }

 private:
  void put(const std::string& name, const std::string& text) const {
    std::ofstream(path_ / name, std::ios::binary) << text;
  }
  fs::path path_;
  sim::PlaneSimulator simulator_;
  std::string log_;
};

}  // namespace

TEST_CASE("time offset: an IMU that is late by a known time") {
  TurnedCamera camera;
  for (const std::int64_t late_us : {0, 3000, -17000, 40000}) {
    Folder folder = camera.open(late_us);
    folder.camera.can.motion.imu_delay_us = 2000;
    const TimeOffset found = estimate_time_offset(folder, 60);
    INFO("late by " << late_us << " us: found " << found.late_ms << " ms, sigma " << found.sigma_ms
                    << ", correlation " << found.correlation << ", " << found.rotation_rad_s << " rad/s");
    CHECK(found.doubt == "");
    CHECK(found.imu_delay_us == Approx(static_cast<double>(late_us)).margin(2000));
    CHECK(found.imu_delay_us == 2000 + std::llround(found.late_ms * 1000));
    CHECK(found.correlation > 0.8);
  }
  // Beyond the range, and with axes that are not the camera's, it is not trusted.
  CHECK(estimate_time_offset(camera.open(40000), 20).doubt != "");
  Folder folder = camera.open(0);
  folder.camera.can.motion.gyro_axes = {{2, 3, 1}};
  CHECK(estimate_time_offset(folder, 60).doubt != "");
}

TEST_CASE("time offset: what cannot be compared is said") {
  // The fixture's camera stands, slides and turns evenly.
  const fs::path fixtures = fs::path(test::source_dir()) / "fixtures";
  CHECK(estimate_time_offset(open_folder(fixtures / "planes", MotionSource::kOdometry), 60).doubt != "");
  Folder folder = open_folder(fixtures / "planes", MotionSource::kOdometry);
  folder.camera.can.motion.signal_count = 1;
  folder.camera.can.motion.signals[0].role = CanRole::kAccelX;
  CHECK_THROWS_AS(estimate_time_offset(folder, 60), Error);
}
