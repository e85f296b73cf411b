// Reading FlatBuffers without generated code: tables, vectors and strings, each offset checked against the
// buffer. A finding outside the buffer throws OutOfBuffer; the caller knows which file it was.
// Format: flatbuffers.dev, "FlatBuffer internals". All numbers are little-endian.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <optional>
#include <span>
#include <string_view>

namespace egofocus::recording {

struct OutOfBuffer : std::exception {
  [[nodiscard]] const char* what() const noexcept override { return "an offset points outside its buffer"; }
};

/// The bytes of one buffer, without a size prefix.
class FlatBuffer {
 public:
  explicit FlatBuffer(std::span<const std::byte> bytes) : bytes_(bytes) {}

  [[nodiscard]] std::uint64_t unsigned_at(std::size_t at, std::size_t size) const {
    if (at > bytes_.size() || size > bytes_.size() - at) throw OutOfBuffer();
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < size; ++i) value |= std::to_integer<std::uint64_t>(bytes_[at + i]) << (8 * i);
    return value;
  }
  [[nodiscard]] std::uint16_t u16_at(std::size_t at) const {
    return static_cast<std::uint16_t>(unsigned_at(at, 2));
  }
  [[nodiscard]] std::uint32_t u32_at(std::size_t at) const {
    return static_cast<std::uint32_t>(unsigned_at(at, 4));
  }
  [[nodiscard]] std::int32_t i32_at(std::size_t at) const { return static_cast<std::int32_t>(u32_at(at)); }
  [[nodiscard]] std::int64_t i64_at(std::size_t at) const {
    return static_cast<std::int64_t>(unsigned_at(at, 8));
  }
  [[nodiscard]] float float_at(std::size_t at) const { return std::bit_cast<float>(u32_at(at)); }
  [[nodiscard]] std::span<const std::byte> part(std::size_t at, std::size_t size) const {
    if (at > bytes_.size() || size > bytes_.size() - at) throw OutOfBuffer();
    return bytes_.subspan(at, size);
  }

  /// The four letters after the root offset, such as "EVTS".
  [[nodiscard]] std::string_view identifier() const {
    return {reinterpret_cast<const char*>(part(4, 4).data()), 4};
  }
  /// Where the root table stands.
  [[nodiscard]] std::size_t root() const { return follow(0); }

  /// Where field `index` of the table at `table` stands; none: the field has its default.
  [[nodiscard]] std::optional<std::size_t> field(std::size_t table, std::size_t index) const {
    const std::int64_t vtable = static_cast<std::int64_t>(table) - i32_at(table);
    if (vtable < 0) throw OutOfBuffer();
    const auto at = static_cast<std::size_t>(vtable);
    const std::size_t entry = 4 + 2 * index;
    if (entry + 2 > u16_at(at)) return {};
    const std::uint16_t offset = u16_at(at + entry);
    if (offset == 0) return {};
    return table + offset;
  }

  /// The target of the relative offset at `at`.
  [[nodiscard]] std::size_t follow(std::size_t at) const { return at + u32_at(at); }

  struct Vector {
    std::size_t first = 0;  ///< where the first element stands
    std::size_t count = 0;
  };
  /// The vector that the offset at `at` leads to; all of its elements lie inside.
  [[nodiscard]] Vector vector(std::size_t at, std::size_t element_bytes) const {
    const std::size_t start = follow(at);
    const std::size_t count = u32_at(start);
    if (count > bytes_.size() / element_bytes) throw OutOfBuffer();
    (void)part(start + 4, count * element_bytes);
    return {start + 4, count};
  }
  [[nodiscard]] std::string_view text(std::size_t at) const {
    const Vector letters = vector(at, 1);
    return {reinterpret_cast<const char*>(part(letters.first, letters.count).data()), letters.count};
  }

 private:
  std::span<const std::byte> bytes_;
};

}  // namespace egofocus::recording
