#include "paced_source.hpp"

#include <algorithm>
#include <array>
#include <span>
#include <utility>

namespace egofocus::daemon {
namespace {

constexpr std::size_t kStagedEvents = 1u << 14;
constexpr std::size_t kStagedSamples = 1u << 9;
constexpr std::size_t kBatch = 256;
constexpr std::int64_t kStep_us = 1000;  // a camera sends about as often

}  // namespace

PacedSource::PacedSource(recording::Folder folder, bool repeat, Recorder& recorder)
    : events_(kStagedEvents),
      imu_(kStagedSamples),
      odometry_(kStagedSamples),
      poses_(kStagedSamples),
      rings_{SpscRing<Event>(events_), SpscRing<ImuSample>(imu_), SpscRing<OdometrySample>(odometry_),
             SpscRing<PoseSample>(poses_)},
      staged_(rings_),
      folder_(std::move(folder)),
      recording_(folder_, {this, tap}),
      inner_(recording_.source()),
      recorder_(recorder),
      repeat_(repeat) {}

Source PacedSource::source() noexcept {
  return {.self = this,
          .name = "replay",
          .start = [](void* self) noexcept { return static_cast<PacedSource*>(self)->start(); },
          .poll =
              [](void* self, Inlets& inlets, std::int64_t, std::int64_t timeout_us) noexcept {
                return static_cast<PacedSource*>(self)->poll(inlets, timeout_us);
              },
          .stop = nullptr};
}

Status PacedSource::start() noexcept {
  begin_now();
  return inner_.start(inner_.self);
}

void PacedSource::begin_now() noexcept {
  offset_us_ = clock_.now_us(clock_.self) - recording_.first_event_us();
  last_us_.store(recording_.last_event_us() + offset_us_, std::memory_order_relaxed);
}

Delivery PacedSource::poll(Inlets& out, std::int64_t timeout_us) noexcept {
  const std::int64_t now_us = clock_.now_us(clock_.self);
  const Delivery got = inner_.poll(inner_.self, staged_, now_us - offset_us_, 0);
  const std::size_t passed =
      pass_events(out) + pass(rings_.imu, out) + pass(rings_.odometry, out) + pass(rings_.poses, out);
  Delivery delivery{.watermark_us = now_us, .ended = false, .status = got.status};
  if (passed > 0) return delivery;
  if (got.ended && repeat_) {
    delivery.status = start();
  } else if (got.ended) {
    ended_.store(true, std::memory_order_release);
    delivery.ended = true;
  } else {
    clock_.sleep_until_us(clock_.self, now_us + std::min(timeout_us, kStep_us));
  }
  return delivery;
}

std::size_t PacedSource::pass_events(Inlets& out) noexcept {
  std::size_t passed = 0;
  std::array<Event, kBatch> batch;
  for (std::span<const Event> ready = rings_.events.peek(kBatch); !ready.empty();
       ready = rings_.events.peek(kBatch)) {
    std::copy(ready.begin(), ready.end(), batch.begin());
    const std::span<Event> moved = std::span(batch).first(ready.size());
    for (Event& event : moved) event.t_us += offset_us_;
    out.push(std::span<const Event>(moved));
    rings_.events.release(moved.size());
    passed += moved.size();
  }
  return passed;
}

template <typename Sample>
std::size_t PacedSource::pass(SpscRing<Sample>& staged, Inlets& out) noexcept {
  std::size_t passed = 0;
  for (std::span<const Sample> ready = staged.peek(1); !ready.empty(); ready = staged.peek(1)) {
    Sample sample = ready[0];
    sample.t_us += offset_us_;
    out.push(std::span<const Sample>(&sample, 1));
    staged.release(1);
    ++passed;
  }
  return passed;
}

void PacedSource::tap(void* self, const CanFrame& frame) noexcept {
  auto& source = *static_cast<PacedSource*>(self);
  CanFrame moved = frame;
  moved.t_us += source.offset_us_;
  source.recorder_.take(moved);
}

}  // namespace egofocus::daemon
