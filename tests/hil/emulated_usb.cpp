#include "hil/emulated_usb.hpp"

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

namespace egofocus::hil {

struct EmulatedUsb::Header {
  std::uint32_t command = 0;
  std::uint32_t sequence = 0;
  std::uint32_t device = 0;
  std::uint32_t direction = 0;  // 1: IN
  std::uint32_t endpoint = 0;
  // A submission: flags, length, start frame, packets, interval. An answer: status, length, start frame,
  // packets, errors. To unlink: the sequence; its answer: a status.
  std::uint32_t words[5] = {};
  std::uint8_t setup[8] = {};
};

namespace {

constexpr std::uint32_t kSubmit = 1;
constexpr std::uint32_t kUnlink = 2;
constexpr std::uint32_t kSubmitAnswer = 3;
constexpr std::uint32_t kUnlinkAnswer = 4;
constexpr std::uint32_t kNoPackets = 0xffffffff;
constexpr std::uint8_t kIn = 0x80;
constexpr int kHighSpeed = 3;  // linux/usb/ch9.h

template <typename Header>
Header swapped(Header header) {
  static_assert(sizeof(Header) == 48);
  std::uint32_t words[10];
  std::memcpy(words, &header, sizeof words);
  for (std::uint32_t& word : words) word = ntohl(word);
  std::memcpy(static_cast<void*>(&header), words, sizeof words);
  return header;
}

}  // namespace

void add_u16(Bytes& bytes, std::uint32_t value) {
  for (int i = 0; i < 2; ++i) bytes.push_back(static_cast<std::uint8_t>(value >> 8 * i));
}

void add_u32(Bytes& bytes, std::uint32_t value) {
  for (int i = 0; i < 4; ++i) bytes.push_back(static_cast<std::uint8_t>(value >> 8 * i));
}

EmulatedUsb::EmulatedUsb(UsbIdentity identity, Bytes configuration)
    : identity_(std::move(identity)), configuration_(std::move(configuration)) {
  configuration_[2] = static_cast<std::uint8_t>(configuration_.size());
  configuration_[3] = static_cast<std::uint8_t>(configuration_.size() >> 8);
}

bool EmulatedUsb::plug(int port) {
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_STREAM, 0, ends) != 0) return false;
  std::FILE* attach = std::fopen("/sys/devices/platform/vhci_hcd.0/attach", "w");
  if (attach == nullptr) return false;
  std::fprintf(attach, "%d %d %d %d\n", port, ends[1], 0x10001 + port, kHighSpeed);
  const bool is_taken = std::fclose(attach) == 0;
  close(ends[1]);  // the kernel holds its own reference
  if (!is_taken) {
    close(ends[0]);
    return false;
  }
  socket_ = ends[0];
  is_leaving_ = false;
  thread_ = std::thread([this] { serve(); });
  return true;
}

bool EmulatedUsb::plug_when_free(int port) {
  for (int i = 0; i < 1000; ++i) {
    if (plug(port)) return true;
    usleep(20'000);
  }
  return false;
}

void EmulatedUsb::unplug() {
  is_leaving_ = true;
  if (thread_.joinable()) thread_.join();
  if (socket_ >= 0) {
    shutdown(socket_, SHUT_RDWR);
    close(socket_);
  }
  socket_ = -1;
  pending_.clear();
}

void EmulatedUsb::serve() {
  while (!is_leaving_) {
    if (!feed_pending()) return;
    pollfd waiting{socket_, POLLIN, 0};
    if (poll(&waiting, 1, 1) > 0 && !take_message()) return;
  }
}

bool EmulatedUsb::move(void* data, std::size_t bytes, bool is_writing) {
  auto* at = static_cast<char*>(data);
  while (bytes > 0) {
    const ssize_t moved = is_writing ? send(socket_, at, bytes, MSG_NOSIGNAL) : recv(socket_, at, bytes, 0);
    if (moved <= 0) return false;
    at += moved;
    bytes -= static_cast<std::size_t>(moved);
  }
  return true;
}

bool EmulatedUsb::reply(std::uint32_t sequence, int status, const Bytes& data, std::uint32_t length) {
  Header answer;
  answer.command = kSubmitAnswer;
  answer.sequence = sequence;
  answer.words[0] = static_cast<std::uint32_t>(status);
  answer.words[1] = length;
  answer.words[3] = kNoPackets;
  answer = swapped(answer);
  Bytes message(sizeof answer);
  std::memcpy(message.data(), &answer, sizeof answer);
  message.insert(message.end(), data.begin(), data.end());
  return move(message.data(), message.size(), true);
}

bool EmulatedUsb::feed_pending() {
  for (auto& [endpoint, queue] : pending_) {
    while (!queue.empty()) {
      Bytes data;
      const int error = in(static_cast<std::uint8_t>(endpoint | kIn), queue.front().most, data);
      if (error == EAGAIN) break;
      const Pending done = queue.front();
      queue.pop_front();
      if (!reply(done.sequence, -error, data, static_cast<std::uint32_t>(data.size()))) return false;
    }
  }
  return true;
}

bool EmulatedUsb::take_message() {
  Header header;
  if (!move(&header, sizeof header, false)) return false;
  header = swapped(header);
  if (header.command == kUnlink) return cancel(header);
  if (header.command != kSubmit) return false;
  Bytes data;
  if (header.direction == 0 && header.words[1] > 0) {
    data.resize(header.words[1]);
    if (!move(data.data(), data.size(), false)) return false;
  }
  if (header.endpoint == 0) return answer_control(header, std::move(data));
  if (header.direction == 0) {
    out(static_cast<std::uint8_t>(header.endpoint), data);
    return reply(header.sequence, 0, {}, header.words[1]);
  }
  pending_[static_cast<std::uint8_t>(header.endpoint)].push_back({header.sequence, header.words[1]});
  return true;
}

bool EmulatedUsb::cancel(const Header& header) {
  int status = 0;  // 0: it had ended before
  for (auto& [endpoint, queue] : pending_) {
    for (auto at = queue.begin(); at != queue.end(); ++at) {
      if (at->sequence != header.words[0]) continue;
      queue.erase(at);
      status = -ECONNRESET;
      break;
    }
  }
  Header answer;
  answer.command = kUnlinkAnswer;
  answer.sequence = header.sequence;
  answer.words[0] = static_cast<std::uint32_t>(status);
  answer = swapped(answer);
  return move(&answer, sizeof answer, true);
}

bool EmulatedUsb::answer_control(const Header& header, Bytes data) {
  const std::uint8_t* s = header.setup;
  const Setup setup{s[0], s[1], static_cast<std::uint16_t>(s[2] | s[3] << 8),
                    static_cast<std::uint16_t>(s[4] | s[5] << 8)};
  const auto length = static_cast<std::size_t>(s[6] | s[7] << 8);
  const bool is_standard = (setup.type & 0x60) == 0;
  const bool is_in = (setup.type & kIn) != 0;
  const std::uint32_t sent = static_cast<std::uint32_t>(data.size());
  const bool is_known = is_standard ? standard_request(setup, data) : control(setup, data);
  if (!is_known) return reply(header.sequence, -EPIPE, {}, 0);
  if (!is_in) return reply(header.sequence, 0, {}, sent);
  if (data.size() > length) data.resize(length);
  return reply(header.sequence, 0, data, static_cast<std::uint32_t>(data.size()));
}

bool EmulatedUsb::standard_request(const Setup& setup, Bytes& data) {
  enum Request {
    kGetStatus = 0,
    kClearFeature = 1,
    kSetFeature = 3,
    kGetDescriptor = 6,
    kGetConfiguration = 8,
    kSetConfiguration = 9,
    kGetInterface = 10,
    kSetInterface = 11
  };
  switch (setup.request) {
    case kGetStatus:
      data = {0, 0};
      return true;
    case kClearFeature:
      if ((setup.type & 0x1f) == 2) halt_cleared(static_cast<std::uint8_t>(setup.index));
      return true;
    case kSetFeature:
    case kSetConfiguration:
    case kSetInterface:
      return true;
    case kGetConfiguration:
      data = {1};
      return true;
    case kGetInterface:
      data = {0};
      return true;
    case kGetDescriptor:
      return descriptor(setup.value >> 8, setup.value & 0xff, data);
    default:
      return false;
  }
}

bool EmulatedUsb::descriptor(int type, std::size_t index, Bytes& data) const {
  enum Type { kDevice = 1, kConfiguration = 2, kText = 3 };
  if (type == kDevice) {
    const std::uint8_t* const kind = identity_.device_class;
    data = {18, kDevice, 0, 2, kind[0], kind[1], kind[2], 64};
    for (const std::uint16_t v : {identity_.vendor, identity_.product, identity_.release}) add_u16(data, v);
    data.insert(data.end(), {1, 2, 3, 1});
  } else if (type == kConfiguration) {
    data = configuration_;
  } else if (type == kText && index == 0) {
    data = {4, kText, 0x09, 0x04};  // English
  } else if (type == kText && index <= identity_.texts.size()) {
    const std::string& text = identity_.texts[index - 1];
    data = {static_cast<std::uint8_t>(2 + 2 * text.size()), kText};
    for (const char letter : text) add_u16(data, static_cast<std::uint8_t>(letter));
  } else {
    return false;
  }
  return true;
}

}  // namespace egofocus::hil
