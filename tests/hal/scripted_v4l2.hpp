// A kernel with one media device, an event sensor and its video node, which does what a test says.
#pragma once

#include <linux/media.h>
#include <linux/v4l2-subdev.h>
#include <linux/videodev2.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <deque>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "core/clock.hpp"
#include "hal/v4l2_io.hpp"

namespace egofocus::test {

class ScriptedV4l2 {
 public:
  static constexpr std::uint32_t kEof = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | V4L2_BUF_FLAG_TSTAMP_SRC_EOF;

  // What a DQBUF gives next: a filled buffer, or an errno. The bytes land at the beginning of whichever
  // buffer is next; the rest of it keeps what it held.
  struct Frame {
    int error = 0;
    std::vector<std::byte> bytes;
    std::int64_t used = -1;  // -1: the size of `bytes`
    std::uint32_t sequence = 0;
    std::uint32_t flags = kEof;
    std::int64_t stamp_us = 0;
    std::uint32_t index = UINT32_MAX;  // to tell instead of the true one
    std::uint32_t data_offset = 0;
  };
  struct Control {
    std::string name;
    std::uint32_t id = 0;
    std::uint32_t type = V4L2_CTRL_TYPE_INTEGER;
    std::int64_t minimum = 0;
    std::int64_t maximum = 255;
    std::int64_t value = 0;
    std::vector<std::string> menu;
    std::uint32_t flags = 0;
  };
  struct Entity {
    std::uint32_t id;
    std::uint32_t type;
    std::string name;
    std::string path;
    std::uint32_t minor;
  };
  struct Link {
    std::uint32_t from;
    std::uint32_t to;
    bool is_enabled;
  };

  std::vector<Entity> entities{{1, MEDIA_ENT_T_V4L2_SUBDEV_SENSOR, "imx636 10-003c", "/dev/v4l-subdev2", 12},
                               {2, MEDIA_ENT_T_V4L2_SUBDEV, "csi2", "/dev/v4l-subdev0", 10},
                               {3, MEDIA_ENT_T_DEVNODE_V4L, "rp1-cfe-csi2_ch0", "/dev/video0", 20},
                               {4, MEDIA_ENT_T_DEVNODE_V4L, "rp1-cfe-fe_image0", "/dev/video4", 24}};
  std::vector<Link> links{{1, 2, true}, {2, 4, false}, {2, 3, true}};
  std::map<std::string, int> open_errors;
  std::map<std::string, std::vector<Control>> controls;
  std::map<std::uint32_t, v4l2_rect> selections{{V4L2_SEL_TGT_NATIVE_SIZE, {0, 0, 1280, 720}}};
  std::uint32_t caps = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
  std::uint32_t fourcc = v4l2_fourcc('P', 'S', 'E', '3');
  std::uint32_t frame_bytes = 8192;
  std::uint32_t planes = 1;
  std::uint32_t driver_buffers = 0;                 // 0: as many as asked for
  std::map<unsigned long, std::deque<int>> errors;  // ioctl -> errnos of its next calls; 0: works
  std::deque<Frame> frames;
  std::deque<int> waits;  // revents or -errno of the next poll()s
  VirtualClock time;

  int open_files = 0;
  int opened = 0;
  int mapped = 0;
  bool is_streaming = false;
  bool held_elsewhere = false;
  std::vector<std::uint32_t> queued;
  std::vector<std::vector<std::byte>> memory;
  std::uint32_t sequence = 0;

  ScriptedV4l2() {
    time.set(1'000'000'000);
    fds_.reserve(4096);
    spent_.reserve(4096);
  }

  // A frame that the driver closed now, next in sequence.
  Frame& frame(std::vector<std::byte> bytes) {
    Frame next;
    next.bytes = std::move(bytes);
    next.sequence = sequence++;
    next.stamp_us = time.now_us();
    frames.push_back(std::move(next));
    return frames.back();
  }
  void fail(int error) {
    Frame next;
    next.error = error;
    frames.push_back(std::move(next));
  }
  std::int64_t value_of(const std::string& path, const std::string& name) {
    for (const Control& control : controls[path]) {
      if (control.name == name) return control.value;
    }
    return INT64_MIN;
  }

  V4l2Io io() {
    V4l2Io io;
    io.self = this;
    io.open = [](void* self, const char* path) noexcept { return of(self).do_open(path); };
    io.close = [](void* self, int) noexcept {
      --of(self).open_files;
      return 0;
    };
    io.ioctl = [](void* self, int fd, unsigned long request, void* argument) noexcept {
      return of(self).do_ioctl(fd, request, argument);
    };
    io.map = [](void* self, int, std::size_t, std::int64_t offset, const std::byte*& at) noexcept {
      ScriptedV4l2& s = of(self);
      at = s.memory[static_cast<std::size_t>(offset)].data();
      ++s.mapped;
      return 0;
    };
    io.unmap = [](void* self, const std::byte*, std::size_t) noexcept {
      --of(self).mapped;
      return 0;
    };
    io.wait = [](void* self, int fd, std::int64_t timeout_us) noexcept {
      return of(self).do_wait(fd, timeout_us);
    };
    io.path_of = [](void* self, std::uint32_t, std::uint32_t minor, std::span<char> out) noexcept {
      for (const Entity& entity : of(self).entities) {
        if (entity.minor != minor) continue;
        std::memcpy(out.data(), entity.path.c_str(), entity.path.size() + 1);
        return 0;
      }
      return -ENOENT;
    };
    io.number_of = [](void* self, int fd, std::uint32_t& major, std::uint32_t& minor) noexcept {
      ScriptedV4l2& s = of(self);
      for (const Entity& entity : s.entities) {
        if (entity.path != s.path(fd)) continue;
        major = 81;
        minor = entity.minor;
        return 0;
      }
      return -ENOENT;
    };
    return io;
  }

 private:
  static ScriptedV4l2& of(void* self) { return *static_cast<ScriptedV4l2*>(self); }
  const std::string& path(int fd) { return fds_[static_cast<std::size_t>(fd - 100)]; }

  int do_open(const std::string& wanted) {
    if (const auto error = open_errors.find(wanted); error != open_errors.end() && error->second != 0)
      return -error->second;
    bool is_there = wanted == "/dev/media0";
    for (const Entity& entity : entities) is_there = is_there || entity.path == wanted;
    if (!is_there) return -ENOENT;
    ++open_files;
    ++opened;
    fds_.push_back(wanted);
    return 100 + static_cast<int>(fds_.size()) - 1;
  }

  int do_wait(int fd, std::int64_t timeout_us) {
    if (fd >= 0 && !waits.empty()) {
      const int result = waits.front();
      waits.pop_front();
      return result;
    }
    if (fd >= 0 && !frames.empty()) return 1;  // POLLIN
    time.set(time.now_us() + timeout_us);
    return 0;
  }

  int do_ioctl(int fd, unsigned long request, void* argument) {
    if (auto& next = errors[request]; !next.empty()) {
      const int error = next.front();
      next.pop_front();
      if (error != 0) return -error;
    }
    switch (request) {
      case MEDIA_IOC_ENUM_ENTITIES:
        return enumerate(*static_cast<media_entity_desc*>(argument));
      case MEDIA_IOC_ENUM_LINKS:
        return enumerate(*static_cast<media_links_enum*>(argument));
      case VIDIOC_QUERY_EXT_CTRL:
        return query(path(fd), *static_cast<v4l2_query_ext_ctrl*>(argument));
      case VIDIOC_QUERYMENU:
        return menu(path(fd), *static_cast<v4l2_querymenu*>(argument));
      case VIDIOC_G_EXT_CTRLS:
      case VIDIOC_S_EXT_CTRLS:
        return exchange(path(fd), request == VIDIOC_S_EXT_CTRLS, *static_cast<v4l2_ext_controls*>(argument));
      case VIDIOC_SUBDEV_G_SELECTION: {
        auto& selection = *static_cast<v4l2_subdev_selection*>(argument);
        const auto found = selections.find(selection.target);
        if (found == selections.end()) return -EINVAL;
        selection.r = found->second;
        return 0;
      }
      case VIDIOC_QUERYCAP: {
        auto& told = *static_cast<v4l2_capability*>(argument);
        std::memcpy(told.driver, "rp1-cfe", 8);
        told.capabilities = caps | V4L2_CAP_DEVICE_CAPS | V4L2_CAP_META_OUTPUT;
        told.device_caps = caps;
        return 0;
      }
      case VIDIOC_G_FMT:
        return format(*static_cast<v4l2_format*>(argument));
      default:
        return queue_ioctl(request, argument);
    }
  }

  int queue_ioctl(unsigned long request, void* argument) {
    switch (request) {
      case VIDIOC_REQBUFS: {
        auto& wanted = *static_cast<v4l2_requestbuffers*>(argument);
        if (held_elsewhere) return -EBUSY;
        if (wanted.count > 0 && driver_buffers != 0) wanted.count = driver_buffers;
        memory.assign(wanted.count, std::vector<std::byte>(frame_bytes));
        queued.clear();
        return 0;
      }
      case VIDIOC_QUERYBUF: {
        auto& buffer = *static_cast<v4l2_buffer*>(argument);
        if (is_multiplanar()) {
          buffer.m.planes[0].length = frame_bytes;
          buffer.m.planes[0].m.mem_offset = buffer.index;
        } else {
          buffer.length = frame_bytes;
          buffer.m.offset = buffer.index;
        }
        return 0;
      }
      case VIDIOC_QBUF:
        queued.push_back(static_cast<v4l2_buffer*>(argument)->index);
        return 0;
      case VIDIOC_DQBUF:
        return dequeue(*static_cast<v4l2_buffer*>(argument));
      case VIDIOC_STREAMON:
        is_streaming = true;
        return 0;
      case VIDIOC_STREAMOFF:
        is_streaming = false;
        return 0;
      default:
        return -ENOTTY;
    }
  }

  int dequeue(v4l2_buffer& buffer) {
    if (frames.empty() || queued.empty()) return -EAGAIN;
    if (const int error = frames.front().error; error != 0) {
      frames.pop_front();
      return -error;
    }
    const Frame& frame = frames.front();
    const std::uint32_t index = queued.front();
    queued.erase(queued.begin());
    std::copy_n(frame.bytes.begin(), std::min(frame.bytes.size(), memory[index].size()),
                memory[index].begin());
    const std::uint32_t used = frame.used < 0 ? static_cast<std::uint32_t>(frame.bytes.size())
                                              : static_cast<std::uint32_t>(frame.used);
    buffer.index = frame.index == UINT32_MAX ? index : frame.index;
    buffer.sequence = frame.sequence;
    buffer.flags = frame.flags;
    buffer.timestamp.tv_sec = static_cast<time_t>(frame.stamp_us / 1'000'000);
    buffer.timestamp.tv_usec = static_cast<suseconds_t>(frame.stamp_us % 1'000'000);
    if (is_multiplanar()) {
      buffer.m.planes[0].bytesused = used;
      buffer.m.planes[0].data_offset = frame.data_offset;
    } else {
      buffer.bytesused = used;
    }
    spent_.push_back(std::move(frames.front()));  // freed with the test, not while a trap is armed
    frames.pop_front();
    return 0;
  }

  bool is_multiplanar() const { return (caps & V4L2_CAP_VIDEO_CAPTURE) == 0; }

  int format(v4l2_format& told) const {
    const bool wants_planes = told.type == V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE;
    if (wants_planes != is_multiplanar()) return -EINVAL;
    if (wants_planes) {
      told.fmt.pix_mp.pixelformat = fourcc;
      told.fmt.pix_mp.num_planes = static_cast<std::uint8_t>(planes);
      told.fmt.pix_mp.plane_fmt[0].sizeimage = frame_bytes;
    } else {
      told.fmt.pix.pixelformat = fourcc;
      told.fmt.pix.sizeimage = frame_bytes;
    }
    return 0;
  }

  int enumerate(media_entity_desc& told) const {
    const std::uint32_t after = told.id & ~MEDIA_ENT_ID_FLAG_NEXT;
    for (const Entity& entity : entities) {
      if (entity.id <= after) continue;
      told = {};
      told.id = entity.id;
      told.type = entity.type;
      std::strncpy(told.name, entity.name.c_str(), sizeof told.name - 1);
      told.pads = 2;
      for (const Link& link : links)
        told.links = static_cast<std::uint16_t>(told.links + (link.from == entity.id));
      told.dev.major = 81;
      told.dev.minor = entity.minor;
      return 0;
    }
    return -EINVAL;
  }
  int enumerate(media_links_enum& told) const {
    std::size_t n = 0;
    for (const Link& link : links) {
      if (link.from != told.entity) continue;
      told.links[n].source.entity = link.from;
      told.links[n].sink.entity = link.to;
      told.links[n++].flags = link.is_enabled ? MEDIA_LNK_FL_ENABLED : 0;
    }
    return 0;
  }
  int query(const std::string& where, v4l2_query_ext_ctrl& told) {
    const std::uint32_t after = told.id & ~(V4L2_CTRL_FLAG_NEXT_CTRL | V4L2_CTRL_FLAG_NEXT_COMPOUND);
    for (const Control& control : controls[where]) {
      if (control.id <= after) continue;
      told = {};
      told.id = control.id;
      told.type = control.type;
      std::strncpy(told.name, control.name.c_str(), sizeof told.name - 1);
      told.minimum = control.minimum;
      told.maximum = control.maximum;
      told.flags = control.flags;
      return 0;
    }
    return -EINVAL;
  }
  int menu(const std::string& where, v4l2_querymenu& told) {
    for (const Control& control : controls[where]) {
      if (control.id != told.id || told.index >= control.menu.size()) continue;
      std::strncpy(reinterpret_cast<char*>(told.name), control.menu[told.index].c_str(),
                   sizeof told.name - 1);
      return 0;
    }
    return -EINVAL;
  }
  int exchange(const std::string& where, bool is_write, v4l2_ext_controls& told) {
    for (Control& control : controls[where]) {
      if (control.id != told.controls[0].id) continue;
      const bool is_wide = control.type == V4L2_CTRL_TYPE_INTEGER64;
      if (is_write) {
        control.value = is_wide ? told.controls[0].value64 : told.controls[0].value;
      } else if (is_wide) {
        told.controls[0].value64 = control.value;
      } else {
        told.controls[0].value = static_cast<std::int32_t>(control.value);
      }
      return 0;
    }
    return -EINVAL;
  }

  std::vector<std::string> fds_;
  std::vector<Frame> spent_;
};

}  // namespace egofocus::test
