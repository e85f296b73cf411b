// EVT3 as a sensor writes it, one event a word pair. Source: Prophesee's description of EVT 3.0.
#pragma once

#include <cstdint>

#include "hil/camera_time.hpp"
#include "hil/emulated_usb.hpp"
#include "hil/event_feed.hpp"

namespace egofocus::hil {

/// Appends the feed's events up to `until_us` and the time reached, as far as `room` bytes go.
inline void add_evt3(EventFeed& feed, CameraTime& time, std::int64_t until_us, std::size_t room,
                     Bytes& data) {
  constexpr std::size_t kLongest = 16;  // both times, row, column, and the time at the end
  std::int64_t high = -1, low = -1;
  const std::size_t begin = data.size();
  const auto has_room = [&] { return data.size() - begin + kLongest <= room; };
  const auto add_time = [&](std::int64_t t_us) {
    if (high != t_us >> 12) add_u16(data, 0x8000 | static_cast<std::uint32_t>(t_us >> 12 & 0xfff));
    if (high != t_us >> 12 || low != (t_us & 0xfff))
      add_u16(data, 0x6000 | static_cast<std::uint32_t>(t_us & 0xfff));
    high = t_us >> 12;
    low = t_us & 0xfff;
  };
  std::int64_t t_us = time.sent_us();
  add_time(t_us);
  for (; feed.next().t_us <= until_us && has_room(); feed.take()) {
    const Event& event = feed.next();
    t_us = event.t_us;
    add_time(t_us);
    add_u16(data, event.y);
    add_u16(data, 0x2000u | static_cast<std::uint32_t>(event.polarity << 11) | event.x);
  }
  if (feed.next().t_us > until_us) t_us = until_us;
  add_time(t_us);
  time.send(t_us);
}

}  // namespace egofocus::hil
