// Bytes of the network between two of its stages: channels innermost (NHWC), a border all around.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/arena.hpp"

namespace egofocus {

/// channels is the stride of a pixel: convolutions that need fewer ignore the rest.
struct TensorShape {
  std::int32_t width = 0;
  std::int32_t height = 0;
  std::int32_t channels = 0;
  std::int32_t border = 0;

  [[nodiscard]] std::int32_t row_stride() const noexcept { return (width + 2 * border) * channels; }
  [[nodiscard]] std::size_t bytes() const noexcept {
    return static_cast<std::size_t>(row_stride()) * static_cast<std::size_t>(height + 2 * border);
  }
};

struct Tensor {
  TensorShape shape;
  std::uint8_t* origin = nullptr;  ///< pixel (0, 0), inside the border

  Tensor() noexcept = default;
  Tensor(const TensorShape& s, std::uint8_t* first_inside) noexcept : shape(s), origin(first_inside) {}
  /// In a buffer of shape.bytes().
  Tensor(const TensorShape& s, Arena arena) noexcept : shape(s) {
    std::uint8_t* const first = arena.array<std::uint8_t>(s.bytes()).data();
    if (first != nullptr) origin = first + s.border * s.row_stride() + s.border * s.channels;
  }

  [[nodiscard]] std::uint8_t* row(std::int32_t y) const noexcept {
    return origin + static_cast<std::int64_t>(y) * shape.row_stride();
  }

  /// Every byte of the border becomes `zero`. Thread: the tensor's. RT: yes.
  void fill_border(std::uint8_t zero) const noexcept {
    const auto side = static_cast<std::size_t>(shape.border * shape.channels);
    const auto whole = static_cast<std::size_t>(shape.row_stride());
    for (std::int32_t y = -shape.border; y < shape.height + shape.border; ++y) {
      std::uint8_t* const begin = row(y) - side;
      if (y < 0 || y >= shape.height) {
        __builtin_memset(begin, zero, whole);
      } else {
        __builtin_memset(begin, zero, side);
        __builtin_memset(begin + whole - side, zero, side);
      }
    }
  }
};

}  // namespace egofocus
