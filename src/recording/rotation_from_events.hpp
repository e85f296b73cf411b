// How fast a camera turned, from its events alone: the rotation that brings a short window of them into
// focus.
//
// Method: G. Gallego, D. Scaramuzza, "Accurate angular velocity estimation with an event camera", RA-L 2017.
// The translation of the camera is not known here and stays in the result as an error that changes slowly.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "egofocus/config.hpp"
#include "egofocus/types.hpp"
#include "pipeline/working_grid.hpp"

namespace egofocus::recording {

/// Angular rate in rad/s in the camera frame (x right, y down, z forward).
using Rate = std::array<double, 3>;

class RotationFromEvents {
 public:
  static constexpr std::size_t kMostEvents = 6000;  ///< of a window; more are thinned evenly
  static constexpr std::size_t kFewestEvents = 500;

  explicit RotationFromEvents(const CameraModel& camera);

  /// The rate about `t_us`, the middle of the window that `events` are of. The search begins at the result of
  /// the call before, so windows come in order. False for a window with too few events.
  bool estimate(std::span<const Event> events, std::int64_t t_us, Rate& rate);

 private:
  struct Seen {
    float x, y;  // normalised
    float dt_s;  // since t_us
  };
  [[nodiscard]] double focus(const Rate& rate);
  double climb(Rate& rate);

  Intrinsics camera_;
  std::vector<Ray> rays_;
  std::vector<Seen> seen_;
  std::vector<std::uint8_t> counts_;
  float cell_px_ = 1;
  Rate last_{0, 0, 0};
};

}  // namespace egofocus::recording
