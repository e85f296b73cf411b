// Reads one member of a NumPy .npz file (a zip of .npy, stored or deflated). Test support: little-endian
// hosts, members without zip64, and no more of the formats than NumPy writes.
#pragma once

#include <zlib.h>

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "recording/text_file.hpp"

namespace egofocus::test {

/// The array's bytes, without the .npy header. Throws std::runtime_error.
inline std::string npz_member(const std::filesystem::path& path, const std::string& name) {
  const std::string zip = recording::read_text_file(path);
  const auto number = [&zip](std::size_t at, std::size_t bytes) {
    if (at + bytes > zip.size()) throw std::runtime_error("npz: truncated");
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < bytes; ++i) {
      value |= std::uint32_t{static_cast<unsigned char>(zip[at + i])} << (8 * i);
    }
    return value;
  };
  // The central directory: sizes in the local headers may be left open.
  const std::size_t end = zip.rfind("PK\x05\x06");
  if (end == std::string::npos) throw std::runtime_error("npz: no directory");
  std::size_t at = number(end + 16, 4);
  for (std::uint32_t entry = 0; entry < number(end + 10, 2); ++entry) {
    const std::uint32_t name_length = number(at + 28, 2);
    if (zip.compare(at + 46, name_length, name + ".npy") == 0) {
      const std::uint32_t method = number(at + 10, 2);
      const std::uint32_t packed = number(at + 20, 4);
      const std::uint32_t plain = number(at + 24, 4);
      const std::size_t local = number(at + 42, 4);
      const std::size_t data = local + 30 + number(local + 26, 2) + number(local + 28, 2);
      if (data + packed > zip.size()) throw std::runtime_error("npz: truncated");
      std::string array(plain, '\0');
      if (method == 0) {
        array = zip.substr(data, plain);
      } else {
        z_stream stream{};
        stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(zip.data() + data));
        stream.avail_in = packed;
        stream.next_out = reinterpret_cast<Bytef*>(array.data());
        stream.avail_out = plain;
        inflateInit2(&stream, -MAX_WBITS);
        const int result = inflate(&stream, Z_FINISH);
        inflateEnd(&stream);
        if (result != Z_STREAM_END) throw std::runtime_error("npz: does not inflate");
      }
      // "\x93NUMPY", version, header length (2 bytes in version 1), header.
      if (array.size() < 10 || array[6] != 1) throw std::runtime_error("npz: not .npy version 1");
      const std::size_t header =
          10u + static_cast<unsigned char>(array[8]) + 256u * static_cast<unsigned char>(array[9]);
      return array.substr(header);
    }
    at += 46 + name_length + number(at + 30, 2) + number(at + 32, 2);
  }
  throw std::runtime_error("npz: no member " + name);
}

/// As values of one type; the caller knows which.
template <typename T>
std::vector<T> npz_array(const std::filesystem::path& path, const std::string& name) {
  const std::string bytes = npz_member(path, name);
  std::vector<T> values(bytes.size() / sizeof(T));
  std::memcpy(values.data(), bytes.data(), values.size() * sizeof(T));
  return values;
}

}  // namespace egofocus::test
