#include <array>
#include <cstring>
#include <fstream>

#include "recording/error.hpp"
#include "recording/png_io.hpp"

namespace egofocus::recording {

PngHeader png_header(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file)
    throw Error(ExitCode::kFile, path.string(), "cannot be opened. Check the path and the permissions.");
  // Signature (8), then the IHDR chunk: length (4), name (4), width (4), height (4), depth (1), colour type
  // (1).
  std::array<unsigned char, 26> head{};
  file.read(reinterpret_cast<char*>(head.data()), static_cast<std::streamsize>(head.size()));
  static constexpr unsigned char kSignature[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  if (file.gcount() != static_cast<std::streamsize>(head.size()) ||
      std::memcmp(head.data(), kSignature, sizeof kSignature) != 0 ||
      std::memcmp(&head[12], "IHDR", 4) != 0) {
    throw Error(ExitCode::kBadFile, path.string(),
                "is no PNG file, or is cut off within its first 26 bytes.");
  }
  const auto big_endian = [&head](std::size_t at) {
    std::int64_t value = 0;
    for (std::size_t i = at; i < at + 4; ++i) value = value * 256 + head[i];
    return value;
  };
  PngHeader header;
  header.width_px = big_endian(16);
  header.height_px = big_endian(20);
  header.bit_depth = head[24];
  switch (head[25]) {
    case 0:
      header.colour = "grey";
      break;
    case 2:
      header.colour = "RGB";
      break;
    case 3:
      header.colour = "palette";
      break;
    case 4:
      header.colour = "grey + alpha";
      break;
    case 6:
      header.colour = "RGBA";
      break;
    default:
      header.colour = "unknown";
  }
  return header;
}

}  // namespace egofocus::recording
