#include "egofocus/status.hpp"

namespace egofocus {
namespace {

// Appends to a caller's buffer; keeps room for the final NUL. No printf in the library: it may allocate and
// lock.
class Line {
 public:
  explicit Line(std::span<char> out) noexcept : out_(out) {}
  Line& text(const char* s) noexcept {
    while (*s != '\0' && size_ + 1 < out_.size()) out_[size_++] = *s++;
    return *this;
  }
  Line& number(std::int64_t value) noexcept {
    char digits[24];
    int n = 0;
    std::uint64_t magnitude =
        value < 0 ? 0 - static_cast<std::uint64_t>(value) : static_cast<std::uint64_t>(value);
    do {
      digits[n++] = static_cast<char>('0' + magnitude % 10);
      magnitude /= 10;
    } while (magnitude != 0);
    if (value < 0) digits[n++] = '-';
    while (n > 0 && size_ + 1 < out_.size()) out_[size_++] = digits[--n];
    return *this;
  }
  std::size_t close() noexcept {
    if (!out_.empty()) out_[size_] = '\0';
    return size_;
  }

 private:
  std::span<char> out_;
  std::size_t size_ = 0;
};

}  // namespace

std::size_t Status::describe(std::span<char> out) const noexcept {
  Line line(out);
  const auto with_value = [&](const char* what, const char* advice) {
    line.text(what).text(": ").text(subject_).text(" (got ").number(value_).text("). ").text(advice);
  };
  switch (code_) {
    case StatusCode::kOk:
      line.text("ok");
      break;
    case StatusCode::kArenaTooSmall:
      line.text("arena too small: ")
          .number(value_)
          .text(" bytes given, ")
          .number(bound_)
          .text(" needed. Ask Engine::required_arena() for the size.");
      break;
    case StatusCode::kArenaMisaligned:
      with_value("arena misaligned", "Its address must be a multiple of 64.");
      break;
    case StatusCode::kBadResolution:
      with_value("bad resolution", "Allowed: 8..1280 by 8..1280 pixels.");
      break;
    case StatusCode::kBadIntrinsics:
      with_value("intrinsics do not fit the resolution",
                 "Focal length and centre must be those of this picture size: check camera.toml against the "
                 "sensor.");
      break;
    case StatusCode::kBadDistortion:
      with_value("distortion cannot be inverted inside the picture",
                 "Check the model's name and its coefficients.");
      break;
    case StatusCode::kBadLadder:
      with_value("bad hypotheses ladder", "See LadderConfig for the ranges.");
      break;
    case StatusCode::kBadRate:
      with_value("bad rate", "See RateConfig for the ranges.");
      break;
    case StatusCode::kBadRing:
      with_value("bad ring", "See RingConfig: capacities are powers of two from 64 to 2^24.");
      break;
    case StatusCode::kBadFilter:
      with_value("bad event filter", "See FilterConfig for the ranges.");
      break;
    case StatusCode::kBadWindow:
      with_value("bad window", "See WindowConfig for the ranges.");
      break;
    case StatusCode::kBadFocus:
      with_value("bad focus setting", "See FocusConfig for the ranges.");
      break;
    case StatusCode::kBadMotion:
      with_value("bad motion setting", "Rotations must be orthonormal, noises positive; see MotionConfig.");
      break;
    case StatusCode::kBadThreads:
      with_value("bad number of threads", "Use 1..8.");
      break;
    case StatusCode::kTooManySources:
      with_value("too many sources", "At most 8 can be attached.");
      break;
    case StatusCode::kBadState:
      line.text("called in the wrong order: ").text(subject_);
      break;
    case StatusCode::kBadHeader:
      line.text("bad header: ")
          .text(subject_)
          .text(" (at ")
          .number(value_)
          .text("). Is the file complete, and of this kind?");
      break;
    case StatusCode::kUnsupportedFormat:
      with_value("unsupported format", "See docs/formats.md for what can be read.");
      break;
    case StatusCode::kParse:
      line.text("cannot parse line ").number(value_).text(": ").text(subject_);
      break;
    case StatusCode::kMissingSignal:
      line.text("the DBC has no such signal: ")
          .text(subject_)
          .text(". Check the names under [[can.signals]] in camera.toml.");
      break;
    case StatusCode::kThread:
      line.text("the system refused: ").text(subject_).text(" (errno ").number(value_).text(")");
      break;
    case StatusCode::kIo:
      line.text("input or output failed: ").text(subject_).text(" (errno ").number(value_).text(")");
      break;
    case StatusCode::kBadTick:
      line.text("no tick can be at ")
          .number(value_)
          .text(" us: ")
          .text(subject_)
          .text(", ")
          .number(bound_)
          .text(" us");
      break;
    case StatusCode::kBadCarry:
      with_value("bad carrying of depth", "See CarryConfig for the ranges.");
      break;
    case StatusCode::kBadModel:
      line.text("bad model: ")
          .text(subject_)
          .text(" (at byte ")
          .number(value_)
          .text(", found ")
          .number(bound_)
          .text("). Is the file complete, and an .efm?");
      break;
    case StatusCode::kUnsupportedModel:
      line.text("unsupported model: ")
          .text(subject_)
          .text(" ")
          .number(value_)
          .text(", known is ")
          .number(bound_)
          .text(". Export it again with this version's training, or update the library.");
      break;
    case StatusCode::kModelMismatch:
      line.text("model and configuration do not fit: ")
          .text(subject_)
          .text(" is ")
          .number(value_)
          .text(", the model needs ")
          .number(bound_)
          .text(".");
      break;
    case StatusCode::kNoDevice:
      line.text("no such device: ")
          .text(subject_)
          .text(" (of its kind there are ")
          .number(value_)
          .text("). `egofocus devices` lists what is on the bus.");
      break;
    case StatusCode::kAmbiguousDevice:
      line.number(value_)
          .text(" devices fit: ")
          .text(subject_)
          .text(". Name one by its serial number; `egofocus devices` lists them.");
      break;
    case StatusCode::kNoPermission:
      line.text("no permission to open the device: ")
          .text(subject_)
          .text(" (errno ")
          .number(value_)
          .text(
              "). USB: install 70-egofocus.rules in /etc/udev/rules.d, join the group plugdev, plug it in "
              "again. V4L2: join the group video, log in again.");
      break;
    case StatusCode::kDeviceBusy:
      line.text("another process holds the device: ")
          .text(subject_)
          .text(" (errno ")
          .number(value_)
          .text("). Close the other viewer, driver or daemon.");
      break;
    case StatusCode::kUnknownFirmware:
      line.text("unknown firmware: ")
          .text(subject_)
          .text(" is ")
          .number(value_)
          .text(", known is ")
          .number(bound_)
          .text(". docs/devices.md has what was read and why nothing is guessed.");
      break;
    case StatusCode::kUnsupportedDevice:
      line.text("this device cannot be driven: ").text(subject_);
      break;
    case StatusCode::kBadDeviceSetting:
      with_value("bad device setting", "docs/devices.md has names and ranges.");
      break;
    case StatusCode::kDeviceLost:
      line.text("device lost: ")
          .text(subject_)
          .text(" (errno ")
          .number(value_)
          .text("). Check cable and power; it is opened again when it is back and reopening is on.");
      break;
  }
  return line.close();
}

}  // namespace egofocus
