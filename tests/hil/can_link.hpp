// What `ip link set can0 type can ...` does, for guests whose busybox cannot: rtnetlink, linux/can/netlink.h.
#pragma once

#include <linux/can/netlink.h>
#include <linux/rtnetlink.h>
#include <net/if.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <string>

namespace egofocus::hil {

/// Sets one attribute of a CAN interface's link data. 0 or -errno.
inline int set_can_attribute(const char* interface_name, unsigned short attribute, const void* value,
                             unsigned short bytes) {
  struct {
    nlmsghdr header;
    ifinfomsg info;
    unsigned char attributes[256];
  } request{};
  request.header.nlmsg_type = RTM_NEWLINK;
  request.header.nlmsg_flags = NLM_F_REQUEST | NLM_F_ACK;
  request.info.ifi_index = static_cast<int>(if_nametoindex(interface_name));
  std::size_t used = 0;
  const auto begin = [&](unsigned short type, const void* data, unsigned short size) {
    auto* attr = reinterpret_cast<rtattr*>(request.attributes + used);
    attr->rta_type = type;
    attr->rta_len = static_cast<unsigned short>(RTA_LENGTH(size));
    if (size > 0) std::memcpy(RTA_DATA(attr), data, size);
    used += RTA_SPACE(size);
    return attr;
  };
  const auto end = [&](rtattr* outer) {
    outer->rta_len =
        static_cast<unsigned short>(request.attributes + used - reinterpret_cast<unsigned char*>(outer));
  };
  rtattr* link = begin(IFLA_LINKINFO, nullptr, 0);
  begin(IFLA_INFO_KIND, "can", 4);
  rtattr* data = begin(IFLA_INFO_DATA, nullptr, 0);
  begin(attribute, value, bytes);
  end(data);
  end(link);
  request.header.nlmsg_len = static_cast<unsigned>(NLMSG_LENGTH(sizeof(ifinfomsg)) + used);

  const int fd = socket(AF_NETLINK, SOCK_RAW, NETLINK_ROUTE);
  if (fd < 0) return -errno;
  struct {
    nlmsghdr header;
    nlmsgerr error;
    unsigned char rest[512];
  } answer{};
  int result = -EIO;
  if (send(fd, &request, request.header.nlmsg_len, 0) > 0 && recv(fd, &answer, sizeof answer, 0) > 0 &&
      answer.header.nlmsg_type == NLMSG_ERROR) {
    result = answer.error.error;
  }
  close(fd);
  return result;
}

inline int set_can_bitrate(const char* interface_name, unsigned bits_per_s) {
  can_bittiming timing{};
  timing.bitrate = bits_per_s;
  return set_can_attribute(interface_name, IFLA_CAN_BITTIMING, &timing, sizeof timing);
}

inline bool appears(const char* interface_name, bool is_there = true) {
  for (int i = 0; i < 1000; ++i) {
    if ((if_nametoindex(interface_name) != 0) == is_there) return true;
    usleep(20000);
  }
  return false;
}

/// Waits for an interface that was plugged in and sets it up, 500 kbit/s.
inline bool raise_can(const char* interface_name) {
  return appears(interface_name) && set_can_bitrate(interface_name, 500000) == 0 &&
         std::system((std::string("ip link set ") + interface_name + " up").c_str()) == 0;
}

}  // namespace egofocus::hil
