// How cameras move without wheels: in a hand, on a drone, on a slider or a small arm.
#pragma once

#include <cstdint>

#include "citysim/trajectory.hpp"
#include "citysim/ways.hpp"

namespace egofocus::citysim {

enum class Flyer : std::uint8_t { kHand, kDrone };

struct FlyStyle {
  Flyer flyer = Flyer::kHand;
  double min_speed_m_s = 0.1;
  double max_speed_m_s = 1.5;
  double max_acceleration_m_s2 = 2;
  double max_rate_rad_s = 1.5;  ///< of the planned turns; tremor comes on top
  double max_roll_rad = 0.52;   ///< hands only: a drone's roll follows its acceleration
  double max_pitch_rad = 0.52;
  double tremor_m_s = 0.01;  ///< rms of the velocity, 3-11 Hz, each axis
  double tremor_rad_s = 0.05;
  /// Kept from a box's sides where it is wide enough, so that a camera's lever arm fits in. Boxes that share
  /// less than two margins have no door between them.
  double margin_m = 0.15;
};

/// Drawn per recording.
[[nodiscard]] FlyStyle fly_style(Flyer flyer, std::uint64_t seed);

/// Travel, turns on the spot, standstill (with tremor, or dead still) and slow drift follow each other at
/// random. Body x looks at one sight after the other. The body's origin never leaves the boxes. Throws
/// std::invalid_argument without boxes or sights, for a box without volume, or a duration outside (0, 1000]
/// s.
[[nodiscard]] Trajectory fly(const Ways& ways, const FlyStyle& style, double duration_s, std::uint64_t seed);

struct SlideStyle {
  bool arm = false;            ///< orbits around a sight, too; else straight strokes with a fixed orientation
  double min_speed_m_s = 0.4;  ///< of a stroke; some are slower, down to a third of it
  double max_speed_m_s = 1.0;
  double ramp_s = 0.3;         ///< from rest to speed
  double max_tilt_rad = 0.35;  ///< of the camera plate off the aim
  double max_roll_rad = 0.1;
  double max_rate_rad_s = 0.8;  ///< in an orbit
};

[[nodiscard]] SlideStyle slide_style(bool arm, std::uint64_t seed);

/// Strokes to and fro in one of the boxes: sideways, forward and mixed, with pauses. The body looks at a
/// sight, off by a random tilt. It never leaves the box. Throws like fly().
[[nodiscard]] Trajectory slide(const Ways& ways, const SlideStyle& style, double duration_s,
                               std::uint64_t seed);

}  // namespace egofocus::citysim
