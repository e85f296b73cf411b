// The result of everything that can fail at set-up. A value, never an exception.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "egofocus/export.hpp"

namespace egofocus {

/// One enumerator per cause.
enum class StatusCode : std::uint8_t {
  kOk = 0,
  kArenaTooSmall,    ///< value = bytes given, bound = bytes needed
  kArenaMisaligned,  ///< the block must start at a multiple of 64 bytes
  kBadResolution,    ///< sensor or grid size out of range
  kBadIntrinsics,    ///< focal length or centre do not fit the resolution
  kBadDistortion,    ///< the distortion model cannot be inverted inside the picture
  kBadLadder,        ///< hypotheses, near limit or span out of range
  kBadRate,          ///< tick rate or lateness out of range
  kBadRing,          ///< a ring capacity is not a power of two or too small
  kBadFilter,
  kBadWindow,
  kBadFocus,
  kBadMotion,  ///< extrinsics or noise settings that cannot be meant
  kBadThreads,
  kTooManySources,
  kBadState,   ///< called in the wrong order (subject says which)
  kBadHeader,  ///< a file header that cannot be understood; value = byte or line
  kUnsupportedFormat,
  kParse,          ///< text that does not parse; value = line
  kMissingSignal,  ///< a DBC without a signal that the configuration names
  kThread,         ///< the system refused a thread or its pinning; value = errno
  kIo,             ///< the system refused I/O; value = errno
  kBadTick,        ///< a tick at a time that cannot be; value = the time, bound = the one it passed
  kBadCarry,       ///< age, travel or view of carried depth out of range
  kBadModel,       ///< a model file that is damaged or none; value = place (byte), bound = what stands there
  kUnsupportedModel,  ///< a model of another version or with an unknown operator; bound = what is known
  kModelMismatch,    ///< a model that does not fit the configuration; value = configured, bound = the model's
  kNoDevice,         ///< no such device is there; value = devices of the kind that were found
  kAmbiguousDevice,  ///< several devices fit; value = how many
  kNoPermission,     ///< the system does not let this user open the device; value = errno
  kDeviceBusy,       ///< another process holds the device; value = errno
  kUnknownFirmware,  ///< value = found, bound = known
  kUnsupportedDevice,  ///< a device of a kind that the library cannot drive; subject says why
  kBadDeviceSetting,   ///< a setting that the device does not have or cannot take; value = as configured
  kDeviceLost,         ///< unplugged, or it stopped answering; value = errno
};

/// `subject` is a static string that names the field or step; `value` and `bound` depend on the code.
class [[nodiscard]] EGOFOCUS_API Status {
 public:
  constexpr Status() noexcept = default;
  constexpr Status(StatusCode code, const char* subject, std::int64_t value = 0,
                   std::int64_t bound = 0) noexcept
      : value_(value), bound_(bound), subject_(subject), code_(code) {}

  [[nodiscard]] constexpr bool ok() const noexcept { return code_ == StatusCode::kOk; }
  [[nodiscard]] constexpr StatusCode code() const noexcept { return code_; }
  [[nodiscard]] constexpr const char* subject() const noexcept { return subject_; }
  [[nodiscard]] constexpr std::int64_t value() const noexcept { return value_; }
  [[nodiscard]] constexpr std::int64_t bound() const noexcept { return bound_; }

  /// One line for people: what, where, what to do. Writes at most out.size() - 1 characters and a final NUL;
  /// returns the characters written. Thread: any. RT: yes.
  std::size_t describe(std::span<char> out) const noexcept;

 private:
  std::int64_t value_ = 0;
  std::int64_t bound_ = 0;
  const char* subject_ = "";
  StatusCode code_ = StatusCode::kOk;
};

}  // namespace egofocus
