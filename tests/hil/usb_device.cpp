#include "hil/usb_device.hpp"

#include <endian.h>
#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>

namespace egofocus::hil {
namespace {

constexpr std::uint32_t kSubmit = 1, kUnlink = 2, kSubmitted = 3, kUnlinked = 4;
constexpr const char* kAttach = "/sys/devices/platform/vhci_hcd.0/attach";
constexpr std::uint8_t kGetDescriptor = 6, kGetStatus = 0, kGetConfiguration = 8, kGetInterface = 10;

// The 48 bytes; what `words` mean depends on the command.
struct Header {
  std::uint32_t command = 0, sequence = 0, device = 0, to_host = 0, endpoint = 0;
  std::uint32_t words[5] =
      {};  // submit: flags, length, ...; submitted: status, length, ...; unlink: sequence
  std::uint8_t setup[8] = {};
};
static_assert(sizeof(Header) == 48);

Header swapped(Header header) {
  std::uint32_t numbers[10];
  std::memcpy(numbers, &header, sizeof numbers);
  for (std::uint32_t& number : numbers) number = be32toh(number);
  std::memcpy(static_cast<void*>(&header), numbers, sizeof numbers);
  return header;
}

class Port {
 public:
  Port(UsbDevice& device, int socket) : device_(device), socket_(socket) {}

  // False when the kernel has gone, or the test pulls the plug.
  bool serve(int commands) {
    pollfd waiting[2] = {{socket_, POLLIN, 0}, {commands, POLLIN, 0}};
    if (poll(waiting, 2, answer_waiting() ? 0 : 1) < 0) return errno == EINTR;
    if ((waiting[1].revents & POLLIN) != 0 && !read_commands(commands)) return false;
    if ((waiting[0].revents & (POLLIN | POLLHUP)) != 0) return read_request();
    return true;
  }

 private:
  struct Waiting {
    std::uint32_t sequence;
    std::uint32_t room;
  };

  bool read_all(void* to, std::size_t bytes) {
    auto* at = static_cast<char*>(to);
    while (bytes > 0) {
      const ssize_t got = recv(socket_, at, bytes, 0);
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) return false;
      at += got;
      bytes -= static_cast<std::size_t>(got);
    }
    return true;
  }

  bool send_all(const Bytes& bytes) {
    std::size_t done = 0;
    while (done < bytes.size()) {
      const ssize_t sent = send(socket_, bytes.data() + done, bytes.size() - done, MSG_NOSIGNAL);
      if (sent < 0 && errno == EINTR) continue;
      if (sent <= 0) return false;
      done += static_cast<std::size_t>(sent);
    }
    return true;
  }

  bool reply(std::uint32_t command, std::uint32_t sequence, std::int32_t status, std::size_t length,
             const Bytes& data) {
    Header header;
    header.command = command;
    header.sequence = sequence;
    header.words[0] = static_cast<std::uint32_t>(status);
    header.words[1] = static_cast<std::uint32_t>(length);
    if (command == kSubmitted) header.words[3] = 0xffffffff;  // no isochronous packets
    header = swapped(header);
    Bytes all(sizeof header);
    std::memcpy(all.data(), &header, sizeof header);
    all.insert(all.end(), data.begin(), data.end());
    return send_all(all);
  }

  // Gives out what the device has. True while more may come at once.
  bool answer_waiting() {
    bool more = false;
    for (auto& [endpoint, queue] : waiting_) {
      for (int i = 0; i < 8 && !queue.empty(); ++i) {
        Bytes data;
        if (!device_.give(endpoint, queue.front().room, data)) break;
        const Waiting first = queue.front();
        queue.pop_front();
        (void)reply(kSubmitted, first.sequence, 0, data.size(), data);
        more = true;
      }
    }
    return more;
  }

  bool read_commands(int commands) {
    char text[512];
    const ssize_t got = read(commands, text, sizeof text);
    if (got > 0) pending_.append(text, static_cast<std::size_t>(got));
    for (std::size_t end; (end = pending_.find('\n')) != std::string::npos;) {
      const std::string line = pending_.substr(0, end);
      pending_.erase(0, end + 1);
      if (line == "unplug") return false;
      device_.command(line);
    }
    return true;
  }

  bool read_request() {
    Header request;
    if (!read_all(&request, sizeof request)) return false;
    request = swapped(request);
    if (request.command == kUnlink) return cancel(request.sequence, request.words[0]);
    if (request.command != kSubmit) return false;
    const auto endpoint = static_cast<std::uint8_t>(request.endpoint);
    const std::uint32_t length = request.words[1];
    if (length > (1u << 24)) return false;
    Bytes sent;
    if (request.to_host == 0 && length > 0) {
      sent.resize(length);
      if (!read_all(sent.data(), length)) return false;
    }
    if (endpoint == 0) return control(request, sent);
    if (request.to_host != 0) {
      waiting_[endpoint].push_back({request.sequence, length});
      return true;
    }
    device_.take(endpoint, sent);
    return reply(kSubmitted, request.sequence, 0, length, {});
  }

  bool cancel(std::uint32_t sequence, std::uint32_t which) {
    std::int32_t status = 0;
    for (auto& [endpoint, queue] : waiting_) {
      const auto found =
          std::find_if(queue.begin(), queue.end(), [which](const Waiting& w) { return w.sequence == which; });
      if (found == queue.end()) continue;
      queue.erase(found);
      status = -ECONNRESET;
    }
    return reply(kUnlinked, sequence, status, 0, {});
  }

  bool control(const Header& request, const Bytes& sent) {
    const std::uint8_t* s = request.setup;
    Setup setup{s[0], s[1], static_cast<std::uint16_t>(s[2] | s[3] << 8),
                static_cast<std::uint16_t>(s[4] | s[5] << 8), static_cast<std::uint16_t>(s[6] | s[7] << 8)};
    Bytes answer;
    const bool is_standard = (setup.type & 0x60) == 0;
    const bool done = is_standard ? standard(setup, answer) : device_.control(setup, sent, answer);
    if (answer.size() > setup.length) answer.resize(setup.length);
    const std::size_t length = request.to_host != 0 ? answer.size() : sent.size();
    if (request.to_host == 0) answer.clear();
    return reply(kSubmitted, request.sequence, done ? 0 : -EPIPE, done ? length : 0, done ? answer : Bytes{});
  }

  bool standard(const Setup& setup, Bytes& answer) const {
    switch (setup.request) {
      case kGetDescriptor:
        return descriptor(setup.value >> 8, setup.value & 0xff, answer);
      case kGetStatus:
        answer = {0, 0};
        return true;
      case kGetConfiguration:
        answer = {1};
        return true;
      case kGetInterface:
        answer = {0};
        return true;
      default:
        return true;  // set address, configuration, interface; clear a halt
    }
  }

  bool descriptor(int type, int number, Bytes& answer) const {
    if (type == 1) answer = device_.device_descriptor;
    if (type == 2) {
      answer = device_.configuration;
      answer[2] = static_cast<std::uint8_t>(answer.size());
      answer[3] = static_cast<std::uint8_t>(answer.size() >> 8);
    }
    if (type == 3 && number == 0) answer = {4, 3, 9, 4};  // English
    if (type == 3 && number > 0 && static_cast<std::size_t>(number) <= device_.strings.size()) {
      const std::string& text = device_.strings[static_cast<std::size_t>(number) - 1];
      answer = {static_cast<std::uint8_t>(2 + 2 * text.size()), 3};
      for (const char c : text) answer.insert(answer.end(), {static_cast<std::uint8_t>(c), 0});
    }
    return !answer.empty();
  }

  UsbDevice& device_;
  int socket_;
  std::map<std::uint8_t, std::deque<Waiting>> waiting_;
  std::string pending_;
};

int complain(const char* what) {
  std::fprintf(stderr, "usb device: %s: %s\n", what, std::strerror(errno));
  return 1;
}

}  // namespace

Bytes device_descriptor(std::uint16_t vendor, std::uint16_t product, std::uint16_t release) {
  const auto low = [](std::uint16_t v) { return static_cast<std::uint8_t>(v); };
  const auto high = [](std::uint16_t v) { return static_cast<std::uint8_t>(v >> 8); };
  return {18,
          1,
          0,
          2,
          0,
          0,
          0,
          64,
          low(vendor),
          high(vendor),
          low(product),
          high(product),
          low(release),
          high(release),
          1,
          2,
          3,
          1};
}

int plug_in(UsbDevice& device, const char* commands) {
  mkfifo(commands, 0600);
  const int pipe = open(commands, O_RDWR | O_NONBLOCK | O_CLOEXEC);  // O_RDWR: it never ends
  if (pipe < 0) return complain(commands);
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) return complain("socketpair");
  std::FILE* attach = std::fopen(kAttach, "w");
  if (attach == nullptr) return complain("modprobe vhci-hcd");
  std::fprintf(attach, "0 %d %u %u\n", ends[1], 0x10001u,
               device.speed);  // port, socket, device number, speed
  if (std::fclose(attach) != 0) return complain(kAttach);
  close(ends[1]);
  Port port(device, ends[0]);
  while (port.serve(pipe)) {
  }
  shutdown(ends[0], SHUT_RDWR);
  close(ends[0]);
  close(pipe);
  unlink(commands);
  return 0;
}

}  // namespace egofocus::hil
