#include "hal/v4l2_controls.hpp"

#include <linux/videodev2.h>

namespace egofocus {
namespace {

constexpr int kMostControls = 1024;  // of a driver that never says "no more"

// As v4l2-ctl prints names: letters small, runs of anything else than letters and digits one underscore.
void spell(std::string_view name, std::span<char, 32> out) noexcept {
  std::size_t used = 0;
  bool gap = false;
  for (const char c : name) {
    if (c == '\0') break;
    const char small = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    if (!((small >= 'a' && small <= 'z') || (small >= '0' && small <= '9'))) {
      gap = used > 0;
      continue;
    }
    if (gap && used + 1 < out.size()) out[used++] = '_';
    gap = false;
    if (used + 1 < out.size()) out[used++] = small;
  }
  out[used] = '\0';
}

bool is_number(std::uint32_t type) noexcept {
  switch (type) {
    case V4L2_CTRL_TYPE_INTEGER:
    case V4L2_CTRL_TYPE_BOOLEAN:
    case V4L2_CTRL_TYPE_MENU:
    case V4L2_CTRL_TYPE_BUTTON:
    case V4L2_CTRL_TYPE_INTEGER64:
    case V4L2_CTRL_TYPE_BITMASK:
    case V4L2_CTRL_TYPE_INTEGER_MENU:
      return true;
    default:
      return false;
  }
}

int exchange(const V4l2File& file, unsigned long request, const V4l2Control& control,
             std::int64_t& value) noexcept {
  const bool is_wide = control.type == V4L2_CTRL_TYPE_INTEGER64;
  v4l2_ext_control one{};
  one.id = control.id;
  if (is_wide) {
    one.value64 = value;
  } else {
    one.value = static_cast<std::int32_t>(value);
  }
  v4l2_ext_controls all{};
  all.which = V4L2_CTRL_WHICH_CUR_VAL;
  all.count = 1;
  all.controls = &one;
  const int code = file.ioctl(request, all);
  if (code < 0) return code;
  value = is_wide ? one.value64 : one.value;
  return 0;
}

}  // namespace

std::size_t list_controls(const V4l2File& file, std::span<V4l2Control> out) noexcept {
  std::size_t found = 0;
  v4l2_query_ext_ctrl query{};
  for (int i = 0; i < kMostControls; ++i) {
    const std::uint32_t before = query.id;
    query = {};
    query.id = before | V4L2_CTRL_FLAG_NEXT_CTRL | V4L2_CTRL_FLAG_NEXT_COMPOUND;
    if (file.ioctl(VIDIOC_QUERY_EXT_CTRL, query) < 0 || query.id == before) break;
    if (!is_number(query.type) || (query.flags & V4L2_CTRL_FLAG_DISABLED) != 0) continue;
    if (found < out.size()) {
      V4l2Control& control = out[found];
      spell({query.name, sizeof query.name}, control.name);
      control.id = query.id;
      control.type = query.type;
      control.flags = query.flags;
      control.minimum = query.minimum;
      control.maximum = query.maximum;
    }
    ++found;
  }
  return found;
}

const V4l2Control* find_control(std::span<const V4l2Control> controls, std::string_view name) noexcept {
  char spelled[32];
  spell(name, spelled);
  for (const V4l2Control& control : controls) {
    if (std::string_view(control.name) == spelled) return &control;
  }
  return nullptr;
}

int read_control(const V4l2File& file, const V4l2Control& control, std::int64_t& value) noexcept {
  return exchange(file, VIDIOC_G_EXT_CTRLS, control, value);
}

int write_control(const V4l2File& file, const V4l2Control& control, std::int64_t value) noexcept {
  return exchange(file, VIDIOC_S_EXT_CTRLS, control, value);
}

int read_menu_text(const V4l2File& file, const V4l2Control& control, std::int64_t index,
                   std::span<char, 32> out) noexcept {
  v4l2_querymenu entry{};
  entry.id = control.id;
  entry.index = static_cast<std::uint32_t>(index);
  if (const int code = file.ioctl(VIDIOC_QUERYMENU, entry); code < 0) return code;
  spell({reinterpret_cast<const char*>(entry.name), sizeof entry.name}, out);
  return 0;
}

}  // namespace egofocus
