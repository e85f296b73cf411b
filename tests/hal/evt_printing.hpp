// Lets Catch compare and print events.
#pragma once

#include <ostream>

#include "egofocus/types.hpp"

namespace egofocus {

inline bool operator==(const Event& a, const Event& b) {
  return a.t_us == b.t_us && a.x == b.x && a.y == b.y && a.polarity == b.polarity;
}
inline std::ostream& operator<<(std::ostream& out, const Event& event) {
  return out << "{t " << event.t_us << ", x " << event.x << ", y " << event.y << ", p " << int{event.polarity}
             << "}";
}

}  // namespace egofocus
