// Too many events are made fewer by their time stamps alone: the same ones each time, on each machine.
#pragma once

#include <cstdint>

namespace egofocus {

/// Time is cut into slots of a millisecond, each with the same budget. Within a slot every n-th event stays,
/// where n is what the slot before would have needed; what still goes beyond the budget does not stay, so a
/// burst is cut in its first slot and spread evenly from its second on. Thread: one. RT: yes.
class EventThinner {
 public:
  /// 0: every event stays; else at least 1000 Hz.
  explicit EventThinner(std::int32_t max_event_rate_hz) noexcept : budget_(max_event_rate_hz / 1000) {}

  [[nodiscard]] bool is_on() const noexcept { return budget_ > 0; }

  bool keep(std::int64_t t_us) noexcept {
    const std::int64_t slot = t_us / kSlot_us;
    if (slot != slot_) {
      step_ = slot == slot_ + 1 && seen_ > budget_ ? (seen_ + budget_ - 1) / budget_ : 1;
      slot_ = slot;
      seen_ = 0;
      kept_ = 0;
    }
    const bool stays = seen_ % step_ == 0 && kept_ < budget_;
    ++seen_;
    if (stays) ++kept_;
    return stays;
  }

 private:
  static constexpr std::int64_t kSlot_us = 1000;

  std::int64_t budget_;  // events per slot
  std::int64_t slot_ = INT64_MIN / 2;
  std::int64_t seen_ = 0;
  std::int64_t kept_ = 0;
  std::int64_t step_ = 1;
};

}  // namespace egofocus
