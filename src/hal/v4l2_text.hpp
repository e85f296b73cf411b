// Short texts put together without printf, which may allocate and lock.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace egofocus {

/// Appends to a text that always ends with NUL; what does not fit is cut. Thread: one. RT: yes.
class V4l2Text {
 public:
  explicit V4l2Text(std::span<char> out) noexcept : out_(out) {
    if (!out_.empty()) out_[0] = '\0';
  }
  V4l2Text& text(std::string_view part) noexcept {
    for (const char c : part) {
      if (used_ + 1 < out_.size()) out_[used_++] = c;
    }
    if (!out_.empty()) out_[used_] = '\0';
    return *this;
  }
  V4l2Text& number(std::int64_t value) noexcept {
    char digits[20];
    std::size_t n = sizeof digits;
    std::uint64_t left =
        value < 0 ? 0 - static_cast<std::uint64_t>(value) : static_cast<std::uint64_t>(value);
    do {
      digits[--n] = static_cast<char>('0' + left % 10);
      left /= 10;
    } while (left != 0);
    if (value < 0) text("-");
    return text({digits + n, sizeof digits - n});
  }
  [[nodiscard]] std::size_t size() const noexcept { return used_; }

 private:
  std::span<char> out_;
  std::size_t used_ = 0;
};

}  // namespace egofocus
