// A recording in memory, for those who play it from the other side.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>
#include <vector>

#include "hal/can_frame.hpp"
#include "hal/candump_decoder.hpp"
#include "hal/evt_decoder.hpp"

namespace egofocus::hil {

struct Recorded {
  std::vector<Event> events;
  std::vector<CanFrame> frames;
  std::int64_t lap_us = 0;  ///< all of it lies before
};

inline std::optional<std::string> bytes_of_file(const std::string& name) {
  std::ifstream file(name, std::ios::binary);
  if (!file.good()) return std::nullopt;
  return std::string{std::istreambuf_iterator<char>(file), {}};
}

inline std::vector<CanFrame> frames_of_log(const std::string& log) {
  CandumpDecoder decoder;
  std::vector<CanFrame> frames(log.size() / 16 + 1);
  const auto bytes = std::as_bytes(std::span(log));
  const Decoded some = decoder.feed(bytes, frames);
  const Decoded last = decoder.finish(bytes.subspan(some.consumed), std::span(frames).subspan(some.produced));
  frames.resize(some.produced + last.produced);
  return frames;
}

/// events.raw and can.log of a folder; nothing when a file is missing, bad or empty.
inline std::optional<Recorded> read_recorded(const std::string& folder) {
  const auto raw = bytes_of_file(folder + "/events.raw");
  const auto log = bytes_of_file(folder + "/can.log");
  RawHeader header;
  if (!raw || !log || !parse_raw_header(std::as_bytes(std::span(*raw)), header).ok()) return std::nullopt;
  Recorded all;
  EvtDecoder decoder(header.format, header.size);
  auto left = std::as_bytes(std::span(*raw)).subspan(header.header_bytes);
  std::array<Event, 1024> some;
  for (Decoded done; (done = decoder.feed(left, some)).produced > 0; left = left.subspan(done.consumed))
    all.events.insert(all.events.end(), some.begin(), some.begin() + static_cast<long>(done.produced));
  all.frames = frames_of_log(*log);
  if (all.events.empty() || all.frames.empty()) return std::nullopt;
  all.lap_us = std::max(all.events.back().t_us, all.frames.back().t_us) + 1000;
  return all;
}

}  // namespace egofocus::hil
