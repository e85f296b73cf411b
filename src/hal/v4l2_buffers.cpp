#include "hal/v4l2_buffers.hpp"

#include <linux/videodev2.h>

#include "hal/device_status.hpp"

namespace egofocus {
namespace {

// The struct of an ioctl on one buffer, and the plane that it points to.
struct BufferCall {
  BufferCall(std::uint32_t type, bool is_multiplanar, std::uint32_t index) noexcept {
    buffer.type = type;
    buffer.memory = V4L2_MEMORY_MMAP;
    buffer.index = index;
    if (!is_multiplanar) return;
    buffer.m.planes = &plane;
    buffer.length = 1;
  }
  BufferCall(const BufferCall&) = delete;
  BufferCall& operator=(const BufferCall&) = delete;

  v4l2_buffer buffer{};
  v4l2_plane plane{};
};

}  // namespace

Status V4l2Buffers::start(bool is_multiplanar, std::uint32_t count) noexcept {
  stop();
  is_multiplanar_ = is_multiplanar;
  type_ = is_multiplanar ? V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE : V4L2_BUF_TYPE_VIDEO_CAPTURE;
  Status status = prepare(count);
  if (status.ok()) status = device_status(-file_->ioctl(VIDIOC_STREAMON, type_), "starting the V4L2 stream");
  if (!status.ok()) stop();
  return status;
}

Status V4l2Buffers::prepare(std::uint32_t count) noexcept {
  v4l2_requestbuffers request{};
  request.count = count;
  request.type = type_;
  request.memory = V4L2_MEMORY_MMAP;
  if (const int code = file_->ioctl(VIDIOC_REQBUFS, request); code < 0)
    return device_status(-code, "V4L2 buffers");
  is_requested_ = true;
  if (request.count < 2 || request.count > kMost)
    return {StatusCode::kIo, "V4L2 buffers: the driver gives another number of them", request.count};
  for (std::uint32_t i = 0; i < request.count; ++i) {
    if (const Status status = map(i); !status.ok()) return status;
  }
  for (std::uint32_t i = 0; i < request.count; ++i) {
    if (const int code = give_back(i); code < 0) return device_status(-code, "queueing a V4L2 buffer");
  }
  return {};
}

Status V4l2Buffers::map(std::uint32_t index) noexcept {
  BufferCall call(type_, is_multiplanar_, index);
  if (const int code = file_->ioctl(VIDIOC_QUERYBUF, call.buffer); code < 0)
    return device_status(-code, "asking for a V4L2 buffer");
  const std::size_t bytes = is_multiplanar_ ? call.plane.length : call.buffer.length;
  const std::uint32_t offset = is_multiplanar_ ? call.plane.m.mem_offset : call.buffer.m.offset;
  const std::byte* memory = nullptr;
  if (const int code = file_->map(bytes, offset, memory); code < 0)
    return device_status(-code, "mapping a V4L2 buffer");
  mappings_[count_++] = {memory, bytes};
  return {};
}

void V4l2Buffers::stop() noexcept {
  if (is_requested_ && file_->is_open()) static_cast<void>(file_->ioctl(VIDIOC_STREAMOFF, type_));
  for (; count_ > 0; --count_) file_->unmap(mappings_[count_ - 1].memory, mappings_[count_ - 1].bytes);
  if (is_requested_ && file_->is_open()) {
    v4l2_requestbuffers none{};
    none.type = type_;
    none.memory = V4L2_MEMORY_MMAP;
    static_cast<void>(file_->ioctl(VIDIOC_REQBUFS, none));
  }
  is_requested_ = false;
}

int V4l2Buffers::take(V4l2Filled& filled) noexcept {
  BufferCall call(type_, is_multiplanar_, 0);
  const v4l2_buffer& buffer = call.buffer;
  if (const int code = file_->ioctl(VIDIOC_DQBUF, call.buffer); code < 0) return code;
  if (buffer.index >= count_) return -EIO;
  const Mapping& mapping = mappings_[buffer.index];
  const std::size_t used = is_multiplanar_ ? call.plane.bytesused : buffer.bytesused;
  const std::size_t before = is_multiplanar_ ? call.plane.data_offset : 0;
  filled = {};
  filled.index = buffer.index;
  filled.sequence = buffer.sequence;
  filled.has_error = (buffer.flags & V4L2_BUF_FLAG_ERROR) != 0;
  filled.is_wrong = used > mapping.bytes || before > used;
  if (!filled.is_wrong) filled.bytes = {mapping.memory + before, used - before};
  // A stamp from the start of exposure lies before the events: it would be no upper bound of their time.
  filled.has_stamp = (buffer.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) == V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC &&
                     (buffer.flags & V4L2_BUF_FLAG_TSTAMP_SRC_MASK) == V4L2_BUF_FLAG_TSTAMP_SRC_EOF;
  constexpr std::int64_t kMostSeconds = 1'000'000'000;
  if (buffer.timestamp.tv_sec < 0 || buffer.timestamp.tv_sec > kMostSeconds) filled.has_stamp = false;
  if (filled.has_stamp)
    filled.stamp_us =
        static_cast<std::int64_t>(buffer.timestamp.tv_sec) * 1'000'000 + buffer.timestamp.tv_usec;
  return 0;
}

int V4l2Buffers::give_back(std::uint32_t index) noexcept {
  BufferCall call(type_, is_multiplanar_, index);
  if (is_multiplanar_) call.plane.length = static_cast<std::uint32_t>(mappings_[index].bytes);
  return file_->ioctl(VIDIOC_QBUF, call.buffer);
}

}  // namespace egofocus
