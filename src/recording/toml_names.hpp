// Names of an enumeration's values, as TOML files spell them.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>
#include <utility>

namespace egofocus::recording {

template <typename Enum, std::size_t N>
using Names = std::array<std::pair<std::string_view, Enum>, N>;

}  // namespace egofocus::recording
