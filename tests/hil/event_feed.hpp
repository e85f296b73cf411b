// What an emulated camera sees: events in the order of their device times, from 0 on.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "egofocus/types.hpp"

namespace egofocus::hil {

class EventFeed {
 public:
  virtual ~EventFeed() = default;
  /// From the beginning again: the camera was started.
  virtual void restart() = 0;
  /// The next event, without taking it.
  [[nodiscard]] virtual const Event& next() const = 0;
  virtual void take() = 0;
};

/// `rate_hz` events, evenly: event k at pixel (k % width, k / width % height) with polarity k % 2, so that a
/// listener sees a missing one.
class CountedEvents : public EventFeed {
 public:
  CountedEvents(double rate_hz, int width_px, int height_px)
      : period_us_(1e6 / rate_hz), width_px_(width_px), height_px_(height_px) {
    CountedEvents::restart();
  }
  void restart() override {
    count_ = 0;
    make();
  }
  [[nodiscard]] const Event& next() const override { return event_; }
  void take() override {
    ++count_;
    make();
  }

 private:
  void make() {
    event_.t_us = static_cast<std::int64_t>(static_cast<double>(count_ + 1) * period_us_);
    event_.x = static_cast<std::uint16_t>(count_ % width_px_);
    event_.y = static_cast<std::uint16_t>(count_ / width_px_ % height_px_);
    event_.polarity = static_cast<std::uint8_t>(event_.y * width_px_ + event_.x) % 2;
  }

  double period_us_;
  std::int64_t width_px_;
  std::int64_t height_px_;
  std::int64_t count_ = 0;
  Event event_;
};

/// A recording, again and again: the next lap begins `lap_us` after the one before.
class RecordedEvents : public EventFeed {
 public:
  /// `events` is not empty, from 0 up to below `lap_us`.
  RecordedEvents(std::vector<Event> events, std::int64_t lap_us)
      : events_(std::move(events)), lap_us_(lap_us), event_(events_.front()) {}
  void restart() override {
    at_ = 0;
    begin_us_ = 0;
    event_ = events_.front();
  }
  [[nodiscard]] const Event& next() const override { return event_; }
  void take() override {
    if (++at_ == events_.size()) {
      at_ = 0;
      begin_us_ += lap_us_;
    }
    event_ = events_[at_];
    event_.t_us += begin_us_;
  }

 private:
  std::vector<Event> events_;
  std::int64_t lap_us_;
  std::size_t at_ = 0;
  std::int64_t begin_us_ = 0;
  Event event_;
};

}  // namespace egofocus::hil
