#include "hal/treuzell_port.hpp"

#include <array>
#include <cerrno>

#include "core/check.hpp"
#include "hal/evt_words.hpp"

namespace egofocus {
namespace {

constexpr std::uint8_t kRequests = 0x02;
constexpr std::uint8_t kAnswers = 0x82;
constexpr std::uint32_t kWrite = 0x40000000;
constexpr std::uint32_t kFailure = 0x80000000;
constexpr std::uint32_t kSensor = 0;
constexpr std::size_t kFrame = 8;  // property, payload bytes
constexpr std::size_t kLongestRequest = kFrame + 4 * 4;
constexpr std::size_t kLongestAnswer = 1024;

std::uint32_t word_at(std::span<const std::byte> bytes, std::size_t at) noexcept {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value |= static_cast<std::uint32_t>(bytes[at + i]) << (8 * i);
  return value;
}

int exchange(UsbConnection& usb, std::uint32_t property, std::span<const std::uint32_t> request,
             std::span<std::byte> answer, std::size_t& got) noexcept {
  EGOFOCUS_CHECK(request.size() <= 4);
  std::array<std::byte, kLongestRequest> sent{};
  std::size_t size = 0;
  write_word(property, std::span<std::byte>(sent), size);
  write_word(static_cast<std::uint32_t>(4 * request.size()), std::span<std::byte>(sent), size);
  for (const std::uint32_t word : request) write_word(word, std::span<std::byte>(sent), size);
  std::size_t moved = 0;
  if (const int error = usb.bulk(kRequests, std::span(sent).first(size), moved); error != 0) return error;
  if (moved != size) return EIO;

  std::array<std::byte, kLongestAnswer> frame;
  if (const int error = usb.bulk(kAnswers, frame, moved); error != 0) return error;
  if (moved < kFrame || word_at(frame, 0) != property) return EPROTO;  // a failure has kFailure set
  static_assert((kFailure & kWrite) == 0);
  got = word_at(frame, 4);
  if (got > moved - kFrame) return EPROTO;
  if (got > answer.size()) return EMSGSIZE;
  for (std::size_t i = 0; i < got; ++i) answer[i] = frame[kFrame + i];
  return 0;
}

}  // namespace

int treuzell_ask(UsbConnection& usb, TreuzellProperty property, std::span<const std::uint32_t> request,
                 std::span<std::byte> answer, std::size_t& got) noexcept {
  return exchange(usb, property, request, answer, got);
}

int treuzell_read_number(UsbConnection& usb, TreuzellProperty property, std::uint64_t& value) noexcept {
  std::array<std::byte, 8> answer{};
  std::size_t got = 0;
  if (const int error = exchange(usb, property, {}, answer, got); error != 0) return error;
  if (got != 4 && got != 8) return EPROTO;
  value = word_at(answer, 0) | std::uint64_t{word_at(answer, 4)} << 32;
  return 0;
}

int treuzell_read(UsbConnection& usb, std::uint32_t address, std::uint32_t& value) noexcept {
  const std::array<std::uint32_t, 3> request{kSensor, address, 1};
  std::array<std::byte, 12> answer{};  // device, address, value
  std::size_t got = 0;
  if (const int error = exchange(usb, kDeviceRegisters, request, answer, got); error != 0) return error;
  if (got != answer.size() || word_at(answer, 4) != address) return EPROTO;
  value = word_at(answer, 8);
  return 0;
}

int treuzell_write(UsbConnection& usb, std::uint32_t address, std::uint32_t value) noexcept {
  const std::array<std::uint32_t, 3> request{kSensor, address, value};
  std::array<std::byte, 64> answer{};
  std::size_t got = 0;
  return exchange(usb, kDeviceRegisters | kWrite, request, answer, got);
}

}  // namespace egofocus
