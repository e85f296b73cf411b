#include "hal/candump_writer.hpp"

namespace egofocus {
namespace {

// Fills the caller's span; remembers when it did not fit.
class Writer {
 public:
  explicit Writer(std::span<char> out) noexcept : out_(out) {}
  void put(char c) noexcept {
    if (size_ < out_.size()) out_[size_] = c;
    ++size_;
  }
  void hex(std::uint32_t value, int digits) noexcept {
    for (int i = digits - 1; i >= 0; --i) put("0123456789ABCDEF"[value >> (4 * i) & 15]);
  }
  // At least `min_digits`, with leading zeros.
  void decimal(std::uint64_t value, int min_digits) noexcept {
    char digits[20];
    int n = 0;
    for (; value != 0 || n < min_digits; value /= 10) digits[n++] = static_cast<char>('0' + value % 10);
    while (n > 0) put(digits[--n]);
  }
  [[nodiscard]] std::size_t size() const noexcept { return size_ <= out_.size() ? size_ : 0; }

 private:
  std::span<char> out_;
  std::size_t size_ = 0;
};

bool is_interface_name(std::string_view name) noexcept {
  if (name.empty() || name.size() > 15) return false;  // the kernel's limit
  for (const char c : name) {
    if (c <= ' ' || c > '~') return false;
  }
  return true;
}

}  // namespace

std::size_t write_candump_line(const CanFrame& frame, std::string_view interface_name,
                               std::span<char> out) noexcept {
  const std::uint32_t max_id = frame.extended ? 0x1FFFFFFF : 0x7FF;
  const std::uint8_t max_length = frame.fd ? 64 : 8;
  if (frame.t_us < 0 || frame.id > max_id || frame.length > max_length || !is_interface_name(interface_name))
    return 0;

  Writer line(out);
  const auto t_us = static_cast<std::uint64_t>(frame.t_us);
  line.put('(');
  line.decimal(t_us / 1000000, 10);
  line.put('.');
  line.decimal(t_us % 1000000, 6);
  line.put(')');
  line.put(' ');
  for (const char c : interface_name) line.put(c);
  line.put(' ');
  line.hex(frame.id, frame.extended ? 8 : 3);
  line.put('#');
  if (frame.fd) {
    line.put('#');
    line.put('0');
  }
  for (std::uint8_t i = 0; i < frame.length; ++i) line.hex(frame.data[i], 2);
  line.put('\n');
  return line.size();
}

}  // namespace egofocus
