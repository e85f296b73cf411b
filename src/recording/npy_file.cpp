#include "recording/npy_file.hpp"

#include <cstring>
#include <string>

#include "recording/text_file.hpp"

namespace egofocus::recording {
namespace {

/// Magic, version, length of the header, header; together a multiple of 64 bytes that ends in a new line.
std::string npy_start(const char* type, std::int32_t width_px, std::int32_t height_px) {
  std::string header = "{'descr': '" + std::string(type) + "', 'fortran_order': False, 'shape': (" +
                       std::to_string(height_px) + ", " + std::to_string(width_px) + "), }";
  constexpr std::size_t kBefore = 10;
  while ((kBefore + header.size() + 1) % 64 != 0) header += ' ';
  header += '\n';
  std::string start("\x93NUMPY\x01\x00", 8);
  start += static_cast<char>(header.size() & 0xff);
  start += static_cast<char>(header.size() >> 8);
  return start + header;
}

}  // namespace

void write_npy(const std::filesystem::path& path, const Picture<float>& picture) {
  std::string bytes = npy_start("<f4", picture.width_px, picture.height_px);
  for (const float value : picture.pixels) {
    std::uint32_t bits = 0;
    std::memcpy(&bits, &value, sizeof bits);
    for (int i = 0; i < 4; ++i) bytes += static_cast<char>((bits >> (8 * i)) & 0xff);
  }
  write_text_file(path, bytes);
}

void write_npy(const std::filesystem::path& path, const GreyPicture& picture) {
  std::string bytes = npy_start("|u1", picture.width_px, picture.height_px);
  for (const std::uint8_t value : picture.pixels) bytes += static_cast<char>(value);
  write_text_file(path, bytes);
}

}  // namespace egofocus::recording
