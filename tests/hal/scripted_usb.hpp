// A USB bus that does what a test says: devices with register models, bytes to stream, errors where wanted.
// Time stands still but in wait() and in the clock's sleeps.
#pragma once

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/clock.hpp"
#include "hal/usb_io.hpp"
#include "made_evt_words.hpp"

namespace scripted {

using egofocus::UsbDevice;
using egofocus::UsbIo;
using egofocus::UsbSetup;
using egofocus::UsbTransfer;
using evt_words::Bytes;

struct Write {
  std::uint32_t address = 0;  // iniVation: module << 16 | parameter
  std::uint32_t value = 0;
  std::int64_t at_us = 0;
};
inline bool operator==(const Write& a, const Write& b) {
  return a.address == b.address && a.value == b.value;
}

/// How one bulk transfer ends.
struct Ending {
  Bytes bytes;
  int error = 0;
};

/// A camera on the bus. iniVation: `registers` are the parameters; Prophesee: the sensor's registers, with
/// the properties in `numbers` and `texts`.
struct Camera {
  UsbDevice descriptor;
  std::string serial;
  int open_error = 0;
  int claim_error = 0;
  bool is_plugged = true;
  std::map<std::uint32_t, std::uint32_t> registers;
  std::map<std::uint32_t, std::uint64_t> numbers;
  std::string texts;
  std::vector<Write> writes;
  std::vector<Ending> endings;
  std::size_t next_ending = 0;
  Bytes answer;
  void (*spoil_answer)(Bytes& answer) = nullptr;  // Prophesee
  void (*after_read)(Camera& camera, std::uint32_t address) = nullptr;
};

class Usb {
 public:
  std::vector<Camera> cameras;
  egofocus::VirtualClock clock;
  int fail_control_after = -1;  // this many more control or bulk requests work
  int control_error = EIO;
  int halts_cleared = 0;
  int submitted = 0;
  int fail_submit_after = -1;
  int interruptions = 0;  // that many wait() return EINTR
  bool is_hung = false;   // transfers in flight never end, cancelled or not
  std::size_t ends_per_wait = 1;
  // What is open: all back at 0 when nothing leaks.
  int buses = 0;
  int devices = 0;
  int prepared = 0;

  Usb() {
    in_flight_.reserve(egofocus_most_);
    clock.set(1'000'000);
  }

  [[nodiscard]] std::size_t in_flight() const { return in_flight_.size(); }
  [[nodiscard]] unsigned timeout_ms() const { return timeout_ms_; }
  [[nodiscard]] bool all_closed() const {
    return buses == 0 && devices == 0 && prepared == 0 && in_flight_.empty();
  }

  UsbIo io() {
    UsbIo io;
    io.self = this;
    io.open_bus = [](void* self, void*& bus) noexcept { return of(self).count(of(self).buses, bus, self); };
    io.close_bus = [](void* self, void*) noexcept { --of(self).buses; };
    io.list = [](void* self, void*, std::span<UsbDevice> out) noexcept { return of(self).list(out); };
    io.open = [](void* self, void*, const UsbDevice& which, void*& device) noexcept {
      return of(self).open(which, device);
    };
    io.close = [](void* self, void*) noexcept { --of(self).devices; };
    io.claim = [](void*, void* device) noexcept { return camera(device).claim_error; };
    io.text = [](void*, void* device, std::uint8_t, std::span<char> out) noexcept {
      out[camera(device).serial.copy(out.data(), out.size() - 1)] = '\0';
      return 0;
    };
    io.control = [](void* self, void* device, const UsbSetup& setup, std::span<std::byte> data,
                    unsigned) noexcept { return of(self).control(camera(device), setup, data); };
    io.bulk = [](void* self, void* device, std::uint8_t endpoint, std::span<std::byte> data,
                 std::size_t& moved, unsigned timeout_ms) noexcept {
      return of(self).bulk(camera(device), endpoint, data, moved, timeout_ms);
    };
    io.clear_halt = [](void* self, void* device, std::uint8_t) noexcept {
      ++of(self).halts_cleared;
      return camera(device).is_plugged ? 0 : ENODEV;
    };
    io.prepare = [](void* self, UsbTransfer& transfer) noexcept {
      return of(self).count(of(self).prepared, transfer.native, self);
    };
    io.release = [](void* self, UsbTransfer& transfer) noexcept {
      --of(self).prepared;
      of(self).forget(transfer);
    };
    io.submit = [](void* self, void* device, std::uint8_t, UsbTransfer& transfer,
                   unsigned timeout_ms) noexcept {
      return of(self).submit(camera(device), transfer, timeout_ms);
    };
    io.cancel = [](void* self, UsbTransfer& transfer) noexcept {
      if (!of(self).is_hung) transfer.error = ECANCELED;  // ends in the next wait()
    };
    io.wait = [](void* self, void*, std::int64_t timeout_us) noexcept { return of(self).wait(timeout_us); };
    return io;
  }

 private:
  static constexpr std::size_t egofocus_most_ = 64;
  struct Sent {
    Camera* camera;
    UsbTransfer* transfer;
  };

  static Usb& of(void* self) { return *static_cast<Usb*>(self); }
  static Camera& camera(void* device) { return *static_cast<Camera*>(device); }
  int count(int& counter, void*& out, void* value) {
    ++counter;
    out = value;
    return 0;
  }

  std::size_t list(std::span<UsbDevice> out) {
    std::size_t n = 0;
    for (const Camera& c : cameras) {
      if (c.is_plugged && n < out.size()) out[n++] = c.descriptor;
    }
    return n;
  }

  int open(const UsbDevice& which, void*& device) {
    for (Camera& c : cameras) {
      if (!c.is_plugged || c.descriptor.address != which.address) continue;
      if (c.open_error != 0) return c.open_error;
      ++devices;
      device = &c;
      return 0;
    }
    return ENODEV;
  }

  int request_error(const Camera& c) {
    if (!c.is_plugged) return ENODEV;
    if (fail_control_after < 0) return 0;
    return fail_control_after-- == 0 ? (++fail_control_after, control_error) : 0;
  }

  int control(Camera& c, const UsbSetup& setup, std::span<std::byte> data) {
    if (const int error = request_error(c); error != 0) return error;
    const auto big_endian = [&data](std::size_t at) {
      std::uint32_t value = 0;
      for (std::size_t i = 0; i < 4; ++i) value = value * 256 + std::to_integer<std::uint32_t>(data[at + i]);
      return value;
    };
    const std::uint32_t address = setup.value * 0x10000u + setup.index;
    if (setup.request == 0xBF && setup.type == 0x40 && data.size() == 4) {
      c.registers[address] = big_endian(0);
      c.writes.push_back({address, big_endian(0), clock.now_us()});
      return 0;
    }
    if (setup.request == 0xBF && setup.type == 0xC0 && data.size() == 4) {
      if (c.registers.count(address) == 0) return EPIPE;
      const std::uint32_t value = c.registers[address];
      for (std::size_t i = 0; i < 4; ++i) data[i] = static_cast<std::byte>(value >> (24 - 8 * i));
      if (c.after_read != nullptr) c.after_read(c, address);
      return 0;
    }
    if (setup.request == 0xC2 && setup.type == 0x40 && data.size() == setup.value * 6u) {
      for (std::size_t at = 0; at < data.size(); at += 6) {
        const std::uint32_t record = std::to_integer<std::uint32_t>(data[at]) * 0x10000u +
                                     std::to_integer<std::uint32_t>(data[at + 1]);
        c.writes.push_back({record, big_endian(at + 2), clock.now_us()});
      }
      return 0;
    }
    return EPIPE;
  }

  int bulk(Camera& c, std::uint8_t endpoint, std::span<std::byte> data, std::size_t& moved,
           unsigned timeout_ms) {
    moved = 0;
    if (const int error = request_error(c); error != 0) return error;
    const auto word = [&data](std::size_t i) {
      std::uint32_t value = 0;
      for (std::size_t k = 0; k < 4; ++k) value |= std::to_integer<std::uint32_t>(data[4 * i + k]) << (8 * k);
      return value;
    };
    if (endpoint == 0x81) {  // the data: read away before the start
      clock.set(clock.now_us() + timeout_ms * 1000);
      return ETIMEDOUT;
    }
    if (endpoint == 0x82) {
      if (c.spoil_answer != nullptr) c.spoil_answer(c.answer);
      moved = c.answer.size();
      std::copy_n(c.answer.begin(), moved, data.begin());
      return 0;
    }
    moved = data.size();
    const std::uint32_t property = word(0);
    c.answer.clear();
    evt_words::append(c.answer, property, 4);
    if (property == 0x10102) {
      evt_words::append(c.answer, 12, 4);
      evt_words::append(c.answer, word(2), 4);
      evt_words::append(c.answer, word(3), 4);
      evt_words::append(c.answer, c.registers[word(3)], 4);
    } else if (property == 0x40010102) {
      evt_words::append(c.answer, 0, 4);
      c.registers[word(3)] = word(4);
      c.writes.push_back({word(3), word(4), clock.now_us()});
    } else if (property == 0x10003) {
      evt_words::append(c.answer, 4 + c.texts.size(), 4);
      evt_words::append(c.answer, word(2), 4);
      for (const char letter : c.texts) c.answer.push_back(static_cast<std::byte>(letter));
    } else if (c.numbers.count(property) != 0) {
      evt_words::append(c.answer, 8, 4);
      evt_words::append(c.answer, c.numbers[property], 8);
    } else {
      c.answer.clear();
      evt_words::append(c.answer, property | 0x80000000u, 4);
      evt_words::append(c.answer, 0, 4);
    }
    return 0;
  }

  int submit(Camera& c, UsbTransfer& transfer, unsigned timeout_ms) {
    if (!c.is_plugged) return ENODEV;
    if (fail_submit_after >= 0 && fail_submit_after-- == 0) return EIO;
    ++submitted;
    timeout_ms_ = timeout_ms;
    transfer.is_in_flight = true;
    transfer.error = 0;
    transfer.length = 0;
    in_flight_.push_back({&c, &transfer});
    return 0;
  }

  void forget(const UsbTransfer& transfer) {
    for (std::size_t i = 0; i < in_flight_.size(); ++i) {
      if (in_flight_[i].transfer == &transfer)
        in_flight_.erase(in_flight_.begin() + static_cast<std::ptrdiff_t>(i));
    }
  }

  void end(std::size_t i, int error) {
    in_flight_[i].transfer->is_in_flight = false;
    in_flight_[i].transfer->error = error;
    in_flight_.erase(in_flight_.begin() + static_cast<std::ptrdiff_t>(i));
  }

  int wait(std::int64_t timeout_us) {
    if (interruptions > 0) {
      --interruptions;
      return EINTR;
    }
    std::size_t ended = 0;
    for (std::size_t i = 0; !is_hung && i < in_flight_.size();) {
      Camera& c = *in_flight_[i].camera;
      UsbTransfer& transfer = *in_flight_[i].transfer;
      if (!c.is_plugged || transfer.error == ECANCELED) {
        end(i, c.is_plugged ? ECANCELED : ENODEV);
        ++ended;
      } else if (ended < ends_per_wait && c.next_ending < c.endings.size()) {
        const Ending& ending = c.endings[c.next_ending++];
        transfer.length = ending.bytes.size();
        std::copy(ending.bytes.begin(), ending.bytes.end(), transfer.buffer.begin());
        end(i, ending.error);
        ++ended;
      } else {
        ++i;
      }
    }
    clock.set(clock.now_us() + (ended > 0 ? 100 : timeout_us));
    return 0;
  }

  std::vector<Sent> in_flight_;
  unsigned timeout_ms_ = 0;
};

}  // namespace scripted
