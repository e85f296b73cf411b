// How the axes of a sensor lie in the body.
#pragma once

#include <cstdint>

namespace egofocus {

/// body[i] = sensor axis |from[i]|, 1 = x, 2 = y, 3 = z, with the sign of from[i]. Handedness is not asked
/// for: some sensors send a left-handed frame.
struct AxisMap {
  std::int8_t from[3] = {1, 2, 3};
};

/// True if the map names each sensor axis once. Thread: any. RT: yes.
inline bool is_permutation(const AxisMap& map) noexcept {
  unsigned seen = 0;
  for (const int from : map.from) {
    const int axis = from < 0 ? -from : from;
    if (axis < 1 || axis > 3) return false;
    seen |= 1u << axis;
  }
  return seen == 0b1110;
}

/// Precondition: is_permutation(map); `sensor` has three values, of another place than `body`. Thread: any.
/// RT: yes.
inline void map_axes(const AxisMap& map, const double* sensor, double (&body)[3]) noexcept {
  for (int i = 0; i < 3; ++i) {
    const int from = map.from[i];
    body[i] = from < 0 ? -sensor[-from - 1] : sensor[from - 1];
  }
}

}  // namespace egofocus
