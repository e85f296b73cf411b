// What training's integer model says of some windows: cases.bin of egofocus_training.vectors.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <map>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace egofocus::test {

struct VectorArray {
  std::uint32_t type = 0;  ///< 1: u8, 2: u16
  std::vector<std::size_t> shape;
  std::vector<std::uint8_t> bytes;

  [[nodiscard]] std::size_t size() const { return bytes.size() / type; }
  [[nodiscard]] std::uint32_t at(std::size_t i) const {
    return type == 1 ? bytes[i] : static_cast<std::uint32_t>(bytes[2 * i] | bytes[2 * i + 1] << 8);
  }
};
using VectorCase = std::map<std::string, VectorArray>;

inline std::string file_bytes(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error("cannot read " + path);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// A model file where its loader wants it: at a multiple of 16.
class ModelMemory {
 public:
  explicit ModelMemory(const std::string& content)
      : blocks_((content.size() + 15) / 16), size_(content.size()) {
    if (!content.empty()) std::memcpy(blocks_.data(), content.data(), content.size());
  }
  [[nodiscard]] std::span<const std::byte> bytes() const {
    return {reinterpret_cast<const std::byte*>(blocks_.data()), size_};
  }

 private:
  struct alignas(16) Block {
    std::byte bytes[16];
  };
  std::vector<Block> blocks_;
  std::size_t size_;
};

/// A case begins with each array named "focus".
inline std::vector<VectorCase> read_cases(const std::string& path) {
  const std::string file = file_bytes(path);
  std::vector<VectorCase> cases;
  std::size_t at = 0;
  const auto number = [&] {
    std::uint32_t value = 0;
    if (at + 4 > file.size()) throw std::runtime_error(path + " is cut short");
    for (int i = 0; i < 4; ++i)
      value |= static_cast<std::uint32_t>(static_cast<std::uint8_t>(file[at++])) << (8 * i);
    return value;
  };
  while (at < file.size()) {
    const std::string name = file.substr(at, 16).c_str();
    at += 16;
    VectorArray array;
    array.type = number();
    array.shape.resize(number());
    std::size_t bytes = array.type;
    for (std::size_t i = 0; i < 4; ++i) {
      const std::size_t length = number();
      bytes *= length;
      if (i < array.shape.size()) array.shape[i] = length;
    }
    if (at + bytes > file.size()) throw std::runtime_error(path + " is cut short");
    array.bytes.assign(file.begin() + static_cast<std::ptrdiff_t>(at),
                       file.begin() + static_cast<std::ptrdiff_t>(at + bytes));
    at += (bytes + 7) / 8 * 8;
    if (name == "focus") cases.emplace_back();
    if (cases.empty()) throw std::runtime_error(path + " does not begin with a focus");
    cases.back()[name] = std::move(array);
  }
  return cases;
}

}  // namespace egofocus::test
