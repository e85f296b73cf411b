#include "hal/inivation_port.hpp"

#include <array>
#include <cerrno>

namespace egofocus {
namespace {

constexpr std::uint8_t kParameter = 0xBF;
constexpr std::uint8_t kParameters = 0xC2;
constexpr std::uint8_t kToDevice = 0x40;
constexpr std::uint8_t kToHost = 0xC0;
constexpr int kReadTries = 4;

UsbSetup one_parameter(std::uint8_t type, std::uint32_t address) noexcept {
  return {.type = type,
          .request = kParameter,
          .value = static_cast<std::uint16_t>(address >> 16),
          .index = static_cast<std::uint16_t>(address & 0xffff)};
}

void store_big_endian(std::uint32_t value, std::span<std::byte, 4> bytes) noexcept {
  for (int i = 0; i < 4; ++i) {
    bytes[static_cast<std::size_t>(i)] = static_cast<std::byte>((value >> (24 - 8 * i)) & 0xff);
  }
}

}  // namespace

int inivation_write(UsbConnection& usb, std::uint32_t address, std::uint32_t value) noexcept {
  std::array<std::byte, 4> bytes;
  store_big_endian(value, bytes);
  return usb.control(one_parameter(kToDevice, address), bytes);
}

int inivation_read(UsbConnection& usb, std::uint32_t address, std::uint32_t& value) noexcept {
  std::array<std::byte, 4> bytes{};
  const int error = usb.control(one_parameter(kToHost, address), bytes);
  value = 0;
  for (const std::byte byte : bytes) value = value << 8 | static_cast<std::uint32_t>(byte);
  return error;
}

int inivation_pulse(UsbConnection& usb, std::uint32_t address) noexcept {
  std::array<std::byte, 12> records{};  // two of module, parameter, value
  for (std::size_t i = 0; i < 2; ++i) {
    const std::span<std::byte> record = std::span(records).subspan(6 * i, 6);
    record[0] = static_cast<std::byte>((address >> 16) & 0xff);
    record[1] = static_cast<std::byte>(address & 0xff);
    store_big_endian(i == 0 ? 1 : 0, record.subspan<2, 4>());
  }
  return usb.control({.type = kToDevice, .request = kParameters, .value = 2, .index = 0}, records);
}

// The halves are read one after the other while the counter runs: only equal upper halves around the lower
// one make a number.
int inivation_read64(UsbConnection& usb, std::uint32_t address, std::uint64_t& value) noexcept {
  std::uint32_t before = 0;
  std::uint32_t after = 0;
  std::uint32_t lower = 0;
  int error = inivation_read(usb, address, before);
  for (int i = 0; error == 0 && i < kReadTries; ++i) {
    error = inivation_read(usb, address + 1, lower);
    if (error == 0) error = inivation_read(usb, address, after);
    if (error == 0 && before == after) {
      value = std::uint64_t{after} << 32 | lower;
      return 0;
    }
    before = after;
  }
  return error == 0 ? EAGAIN : error;
}

}  // namespace egofocus
