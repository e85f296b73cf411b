// V4L2 controls by name: ids differ between drivers, names do not.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "hal/v4l2_file.hpp"

namespace egofocus {

/// One control of an opened node. `name` is written as v4l2-ctl does: small letters, digits, underscores.
struct V4l2Control {
  char name[32] = {};
  std::uint32_t id = 0;
  std::uint32_t type = 0;  ///< V4L2_CTRL_TYPE_*
  std::uint32_t flags = 0;
  std::int64_t minimum = 0;
  std::int64_t maximum = 0;
};

/// All controls of a node that carry one number; writes as many as fit, returns how many there are. 0 also
/// for a node without controls. Thread: any. RT: no.
std::size_t list_controls(const V4l2File& file, std::span<V4l2Control> out) noexcept;

/// Finds a control by any spelling of its name that v4l2-ctl would print alike; nullptr: there is none.
/// Thread: any. RT: yes.
const V4l2Control* find_control(std::span<const V4l2Control> controls, std::string_view name) noexcept;

/// 0 or -errno. Thread: any. RT: no.
int read_control(const V4l2File& file, const V4l2Control& control, std::int64_t& value) noexcept;
int write_control(const V4l2File& file, const V4l2Control& control, std::int64_t value) noexcept;

/// The text of a menu's entry, spelled as names are. 0 or -errno. Thread: any. RT: no.
int read_menu_text(const V4l2File& file, const V4l2Control& control, std::int64_t index,
                   std::span<char, 32> out) noexcept;

}  // namespace egofocus
