// Recordings whose IMU is late by a known time.
#include "recording/time_offset.hpp"

#include <catch2/catch.hpp>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "recording/error.hpp"
#include "support/source_dir.hpp"

using namespace egofocus;
using namespace egofocus::recording;
namespace fs = std::filesystem;

namespace {

// A copy of a fixture, its CAN log moved by a time.
class Moved {
 public:
  Moved(const char* fixture, std::int64_t by_us)
      : path_(fs::temp_directory_path() / ("egofocus_time_offset_" + std::string(fixture))) {
    const fs::path from = fs::path(test::source_dir()) / "fixtures" / fixture;
    fs::remove_all(path_);
    fs::create_directories(path_);
    for (const auto& file : fs::directory_iterator(from)) {
      if (file.is_regular_file() && file.path().filename() != "can.log")
        fs::copy_file(file.path(), path_ / file.path().filename());
    }
    std::ifstream in(from / "can.log");
    std::ofstream out(path_ / "can.log");
    for (std::string line; std::getline(in, line);) {
      long long seconds = 0, micro = 0;
      int end = 0;
      REQUIRE(std::sscanf(line.c_str(), "(%lld.%lld)%n", &seconds, &micro, &end) == 2);
      const long long t = seconds * 1000000 + micro + by_us;
      if (t < 0) continue;
      char time[48];
      std::snprintf(time, sizeof time, "(%lld.%06lld)", t / 1000000, t % 1000000);
      out << time << line.substr(static_cast<std::size_t>(end)) << '\n';
    }
  }
  ~Moved() { fs::remove_all(path_); }
  Moved(const Moved&) = delete;
  Moved& operator=(const Moved&) = delete;
  [[nodiscard]] Folder open() const { return open_folder(path_, MotionSource::kOdometry); }

 private:
  fs::path path_;
};

}  // namespace

TEST_CASE("time offset: a simulated drive, its IMU moved to and fro", "[long]") {
  const TimeOffset still = estimate_time_offset(Moved("town5_night", 0).open(), 60);
  INFO("late " << still.late_ms << " ms, sigma " << still.sigma_ms << ", correlation " << still.correlation);
  CHECK(still.doubt == "");
  // The drive was simulated with the delay that its camera.toml states.
  CHECK(still.old_imu_delay_us == 6257);
  CHECK(still.late_ms == Approx(0).margin(2.5));
  for (const std::int64_t by_us : {-31000, 12000, 40000}) {
    const TimeOffset found = estimate_time_offset(Moved("town5_night", by_us).open(), 60);
    INFO("moved by " << by_us << " us: late " << found.late_ms << " ms, sigma " << found.sigma_ms);
    CHECK(found.doubt == "");
    CHECK(found.late_ms - still.late_ms == Approx(static_cast<double>(by_us) / 1000).margin(1));
    CHECK(found.imu_delay_us == 6257 + std::llround(found.late_ms * 1000));
  }
}

TEST_CASE("time offset: beyond the range, and without a gyro, it is not trusted", "[long]") {
  CHECK(estimate_time_offset(Moved("town5_night", 40000).open(), 20).doubt != "");
  Folder folder = Moved("town5_night", 0).open();
  folder.camera.can.motion.signal_count = 0;
  CHECK_THROWS_AS(estimate_time_offset(folder, 20), Error);
}
