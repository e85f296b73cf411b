// libpng reports errors by longjmp. So nothing with a destructor lives in the functions that call setjmp;
// they work on plain pointers, and their callers own the memory and the file.
#include "recording/png_io.hpp"

#include <cerrno>
#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <memory>
#include <string>

#include "recording/error.hpp"
#include "recording/whole_file.hpp"

#ifdef EGOFOCUS_HAVE_PNG
#include <png.h>

namespace egofocus::recording {
namespace {

constexpr png_uint_32 kMaxSidePx = 16384;

struct Message {
  char text[160] = "";
};

void on_error(png_structp png, png_const_charp text) {
  auto* message = static_cast<Message*>(png_get_error_ptr(png));
  std::snprintf(message->text, sizeof message->text, "%s", text);
  png_longjmp(png, 1);
}

void on_warning(png_structp, png_const_charp) {}

struct FileCloser {  // of files that are read
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, FileCloser>;

/// Raw view of a picture: libpng's format, and bytes of one row.
struct Form {
  int colour_type;
  int bit_depth;
  int compression;  // colours are for looking at once: a sixth larger, four times as fast
  const char* name;
};
constexpr Form kGrey{PNG_COLOR_TYPE_GRAY, 8, 9, "8-bit grey"};
constexpr Form kGrey16{PNG_COLOR_TYPE_GRAY, 16, 9, "16-bit grey"};
constexpr Form kRgb{PNG_COLOR_TYPE_RGB, 8, 4, "8-bit RGB"};

bool host_is_little_endian() {
  const std::uint16_t one = 1;
  unsigned char first = 0;
  std::memcpy(&first, &one, 1);
  return first == 1;
}

bool write_pixels(std::FILE* file, Message* message, const Form* form, png_uint_32 width, png_uint_32 height,
                  const unsigned char* pixels, std::size_t row_bytes) {
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, message, on_error, on_warning);
  if (!png) return false;
  png_infop info = png_create_info_struct(png);
  if (!info || setjmp(png_jmpbuf(png))) {
    png_destroy_write_struct(&png, &info);
    return false;
  }
  png_init_io(png, file);
  png_set_compression_level(png, form->compression);
  png_set_IHDR(png, info, width, height, form->bit_depth, form->colour_type, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_write_info(png, info);
  if (form->bit_depth == 16 && host_is_little_endian()) png_set_swap(png);
  for (png_uint_32 y = 0; y < height; ++y) png_write_row(png, pixels + y * row_bytes);
  png_write_end(png, nullptr);
  png_destroy_write_struct(&png, &info);
  return true;
}

/// Memory comes from `allocate` once the size is known and checked.
using Allocate = unsigned char* (*)(void* picture, png_uint_32 width, png_uint_32 height);

bool read_pixels(std::FILE* file, Message* message, const Form* form, std::size_t pixel_bytes, void* picture,
                 Allocate allocate) {
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, message, on_error, on_warning);
  if (!png) return false;
  png_infop info = png_create_info_struct(png);
  if (!info || setjmp(png_jmpbuf(png))) {
    png_destroy_read_struct(&png, &info, nullptr);
    return false;
  }
  png_init_io(png, file);
  png_set_user_limits(png, kMaxSidePx, kMaxSidePx);
  png_read_info(png, info);
  if (png_get_color_type(png, info) != form->colour_type || png_get_bit_depth(png, info) != form->bit_depth) {
    png_error(png, "is of another form");
  }
  if (png_get_interlace_type(png, info) != PNG_INTERLACE_NONE) png_error(png, "is interlaced");
  if (form->bit_depth == 16 && host_is_little_endian()) png_set_swap(png);
  const png_uint_32 width = png_get_image_width(png, info);
  const png_uint_32 height = png_get_image_height(png, info);
  unsigned char* const pixels = allocate(picture, width, height);
  if (!pixels) png_error(png, "needs more memory than there is");
  for (png_uint_32 y = 0; y < height; ++y) png_read_row(png, pixels + y * (width * pixel_bytes), nullptr);
  png_read_end(png, nullptr);
  png_destroy_read_struct(&png, &info, nullptr);
  return true;
}

template <typename Pixel>
unsigned char* allocate_picture(void* picture, png_uint_32 width, png_uint_32 height) {
  try {
    auto* out = static_cast<Picture<Pixel>*>(picture);
    *out = Picture<Pixel>(static_cast<std::int32_t>(width), static_cast<std::int32_t>(height));
    return reinterpret_cast<unsigned char*>(out->pixels.data());
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
}

template <typename Pixel>
void write_picture(const std::filesystem::path& path, const Picture<Pixel>& picture, const Form& form) {
  WholeFile file(path);
  Message message;
  errno = 0;
  if (!write_pixels(file.file(), &message, &form, static_cast<png_uint_32>(picture.width_px),
                    static_cast<png_uint_32>(picture.height_px),
                    reinterpret_cast<const unsigned char*>(picture.pixels.data()),
                    static_cast<std::size_t>(picture.width_px) * sizeof(Pixel))) {
    file.refuse(message.text);
  }
  file.finish();
}

template <typename Pixel>
Picture<Pixel> read_picture(const std::filesystem::path& path, const Form& form) {
  const PngHeader header = png_header(path);
  File file(std::fopen(path.c_str(), "rb"));
  if (!file)
    throw Error(ExitCode::kFile, path.string(), "cannot be opened. Check the path and the permissions.");
  Picture<Pixel> picture;
  Message message;
  if (!read_pixels(file.get(), &message, &form, sizeof(Pixel), &picture, allocate_picture<Pixel>)) {
    throw Error(ExitCode::kBadFile, path.string(),
                std::string("is no good ") + form.name + " PNG (" + message.text + "; found " +
                    std::to_string(header.width_px) + "x" + std::to_string(header.height_px) + ", " +
                    std::to_string(header.bit_depth) + "-bit " + header.colour + ").");
  }
  return picture;
}

}  // namespace

bool png_available() noexcept {
  return true;
}
void write_png(const std::filesystem::path& path, const GreyPicture& picture) {
  write_picture(path, picture, kGrey);
}
void write_png(const std::filesystem::path& path, const Grey16Picture& picture) {
  write_picture(path, picture, kGrey16);
}
void write_png(const std::filesystem::path& path, const RgbPicture& picture) {
  write_picture(path, picture, kRgb);
}
GreyPicture read_grey_png(const std::filesystem::path& path) {
  return read_picture<std::uint8_t>(path, kGrey);
}
Grey16Picture read_grey16_png(const std::filesystem::path& path) {
  return read_picture<std::uint16_t>(path, kGrey16);
}
RgbPicture read_rgb_png(const std::filesystem::path& path) {
  return read_picture<Rgb>(path, kRgb);
}

}  // namespace egofocus::recording

#else

namespace egofocus::recording {
namespace {

[[noreturn]] void no_png(const std::filesystem::path& path) {
  throw Error(ExitCode::kFile, path.string(),
              "PNG pictures need libpng, and this build has none. Debian: apt-get install libpng-dev, then "
              "build again.");
}

}  // namespace

bool png_available() noexcept {
  return false;
}
void write_png(const std::filesystem::path& path, const GreyPicture&) {
  no_png(path);
}
void write_png(const std::filesystem::path& path, const Grey16Picture&) {
  no_png(path);
}
void write_png(const std::filesystem::path& path, const RgbPicture&) {
  no_png(path);
}
GreyPicture read_grey_png(const std::filesystem::path& path) {
  no_png(path);
}
Grey16Picture read_grey16_png(const std::filesystem::path& path) {
  no_png(path);
}
RgbPicture read_rgb_png(const std::filesystem::path& path) {
  no_png(path);
}

}  // namespace egofocus::recording

#endif
