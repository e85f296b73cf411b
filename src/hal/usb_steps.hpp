// What is done to a camera, as data: register writes and waits in their order.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/check.hpp"

namespace egofocus {

enum class UsbStepKind : std::uint8_t {
  kWrite,      ///< register = value
  kSet,        ///< the bits of `mask` become those of `value`, the others stay
  kOffset,     ///< the low 8 bits move by the signed `value`, within 0..255; the others stay
  kPulse,      ///< 1, then 0, in one request
  kTransfers,  ///< the endpoint's halt is cleared, old data are read away, the transfers are submitted
};

/// A register's address means what the camera's family makes of it (inivation_address(), IMX636 address).
struct UsbStep {
  UsbStepKind kind = UsbStepKind::kWrite;
  std::uint32_t address = 0;
  std::uint32_t value = 0;
  std::uint32_t mask = 0;
  std::uint32_t wait_us = 0;  ///< after it
};

/// A list with room for the longest start sequence there is. Thread: one. RT: yes.
class UsbSteps {
 public:
  void add(const UsbStep& step) noexcept {
    EGOFOCUS_CHECK(count_ < items_.size());
    if (count_ < items_.size()) items_[count_++] = step;
  }
  void write(std::uint32_t address, std::uint32_t value) noexcept {
    add({.kind = UsbStepKind::kWrite, .address = address, .value = value});
  }
  void add(std::span<const UsbStep> steps) noexcept {
    for (const UsbStep& step : steps) add(step);
  }
  /// After the last step. Precondition: there is one.
  void wait(std::uint32_t wait_us) noexcept { items_[count_ - 1].wait_us = wait_us; }
  void clear() noexcept { count_ = 0; }

  [[nodiscard]] std::span<const UsbStep> items() const noexcept { return {items_.data(), count_}; }

 private:
  std::array<UsbStep, 224> items_;
  std::size_t count_ = 0;
};

}  // namespace egofocus
