// iniVation's streams: layout, cut and room come from the first three bytes, the stream is the rest.
#include <vector>

#include "fuzz/fuzz_input.hpp"
#include "hal/inivation_decoder.hpp"

using namespace egofocus;

namespace {

struct Samples {
  std::vector<Event> events;
  std::vector<ImuSample> imu;
};

Samples decode(InivationDecoder& decoder, std::span<const std::byte> bytes, std::size_t room,
               std::size_t cut) {
  Samples all;
  std::vector<Event> events(room);
  std::vector<ImuSample> imu(room);
  for (;;) {
    const std::span<const std::byte> piece = bytes.first(cut < bytes.size() ? cut : bytes.size());
    const InivationDecoded done = decoder.feed(piece, events, imu);
    const bool is_full = done.events == room || done.imu == room;
    fuzz::require(done.consumed <= piece.size() && done.events <= room && done.imu <= room);
    fuzz::require(is_full || done.consumed == piece.size());
    all.events.insert(all.events.end(), events.begin(),
                      events.begin() + static_cast<std::ptrdiff_t>(done.events));
    all.imu.insert(all.imu.end(), imu.begin(), imu.begin() + static_cast<std::ptrdiff_t>(done.imu));
    bytes = bytes.subspan(done.consumed);
    if (bytes.empty() && !is_full) return all;
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::span<const std::byte> bytes = std::as_bytes(std::span(data, size));
  const std::uint8_t kind = fuzz::take_byte(bytes);
  const InivationLayout layout{
      .format = kind % 2 == 0 ? InivationFormat::kDavis : InivationFormat::kDvxplorer,
      .sent = {346, 260},
      .swaps_xy = (kind & 2) != 0,
      .imu_flips = kind >> 2 & 7u};
  const std::size_t cut = std::size_t{1} + fuzz::take_byte(bytes);
  const std::size_t room = std::size_t{1} + fuzz::take_byte(bytes);

  InivationDecoder whole(layout);
  const Samples samples = decode(whole, bytes, 4096, SIZE_MAX);
  const SensorSize allowed = layout.size();
  std::int64_t newest_us = 0;
  for (const Event& event : samples.events) {
    fuzz::require(event.x < allowed.width_px && event.y < allowed.height_px && event.polarity <= 1);
    // Only a reset of the camera's clock may take time back.
    fuzz::require(event.t_us >= newest_us || whole.counters().time_resets > 0);
    newest_us = event.t_us;
  }
  fuzz::require(whole.counters().events == samples.events.size());
  fuzz::require(whole.counters().imu_samples == samples.imu.size());

  InivationDecoder pieces(layout);
  const Samples again = decode(pieces, bytes, room, cut);
  fuzz::require(again.events.size() == samples.events.size() && again.imu.size() == samples.imu.size());
  for (std::size_t i = 0; i < samples.events.size(); ++i)
    fuzz::require(fuzz::same(samples.events[i], again.events[i]));
  fuzz::require(pieces.counters().violations == whole.counters().violations);
  fuzz::require(pieces.counters().dropped_events == whole.counters().dropped_events);
  return 0;
}
