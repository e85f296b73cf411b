// A recording as if it happened now: its samples come when the clock says so, on the host's time, in place of
// a camera and a bus. A full ring loses samples, as with a camera.
#pragma once

#include <atomic>
#include <cstdint>
#include <vector>

#include "core/clock.hpp"
#include "core/inlets.hpp"
#include "egofocus/source.hpp"
#include "recorder.hpp"
#include "recording/folder.hpp"
#include "recording/recording_source.hpp"

namespace egofocus::daemon {

class PacedSource {
 public:
  /// The first event comes when the source starts. `repeat`: from the beginning again at the end. Throws
  /// Error.
  PacedSource(recording::Folder folder, bool repeat, Recorder& recorder);

  /// This object must outlive the copy. poll() RT: yes.
  [[nodiscard]] Source source() noexcept;

  /// All is out, and it was older than `t_us` on the host's clock. Thread: any.
  [[nodiscard]] bool ends_before(std::int64_t t_us) const noexcept {
    return ended_.load(std::memory_order_acquire) && t_us > last_us_.load(std::memory_order_relaxed);
  }

 private:
  Status start() noexcept;
  Delivery poll(Inlets& out, std::int64_t timeout_us) noexcept;
  void begin_now() noexcept;
  std::size_t pass_events(Inlets& out) noexcept;
  template <typename Sample>
  std::size_t pass(SpscRing<Sample>& staged, Inlets& out) noexcept;
  static void tap(void* self, const CanFrame& frame) noexcept;

  // What the recording gives lies here, until its times are the host's.
  std::vector<Event> events_;
  std::vector<ImuSample> imu_;
  std::vector<OdometrySample> odometry_;
  std::vector<PoseSample> poses_;
  Inlets::Rings rings_;
  Inlets staged_;

  recording::Folder folder_;
  recording::RecordingSource recording_;
  Source inner_;
  Recorder& recorder_;
  Clock clock_ = monotonic_clock();
  bool repeat_;
  std::int64_t offset_us_ = 0;  // from the recording's time to the host's
  std::atomic<std::int64_t> last_us_{0};
  std::atomic<bool> ended_{false};
};

}  // namespace egofocus::daemon
