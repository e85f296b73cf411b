#include "recording/png_io.hpp"

#include <catch2/catch.hpp>

#include "recording/error.hpp"
#include "recording/temporary_folder.hpp"
#include "recording/text_file.hpp"

using namespace egofocus;
using namespace egofocus::recording;
using Catch::Matchers::Contains;

namespace {

template <typename Call>
std::string complaint(ExitCode code, Call call) {
  try {
    call();
  } catch (const Error& error) {
    CHECK(error.exit_code() == static_cast<int>(code));
    return error.what();
  }
  return "no complaint";
}

}  // namespace

TEST_CASE("pictures come back from PNG as they were") {
  if (!png_available()) {
    WARN("built without libpng: PNG round trips not exercised");
    return;
  }
  const TemporaryFolder folder;
  GreyPicture grey(7, 3);
  Grey16Picture grey16(5, 4);
  RgbPicture rgb(3, 2);
  for (std::size_t i = 0; i < grey.pixels.size(); ++i) grey.pixels[i] = static_cast<std::uint8_t>(i * 12);
  for (std::size_t i = 0; i < grey16.pixels.size(); ++i)
    grey16.pixels[i] = static_cast<std::uint16_t>(i * 3400 + 1);
  for (std::size_t i = 0; i < rgb.pixels.size(); ++i) rgb.pixels[i] = {static_cast<std::uint8_t>(i), 200, 7};
  write_png(folder / "grey.png", grey);
  write_png(folder / "grey16.png", grey16);
  write_png(folder / "rgb.png", rgb);
  CHECK(read_grey_png(folder / "grey.png").pixels == grey.pixels);
  CHECK(read_grey16_png(folder / "grey16.png").pixels == grey16.pixels);
  CHECK(read_rgb_png(folder / "rgb.png").pixels == rgb.pixels);

  const PngHeader header = png_header(folder / "grey16.png");
  CHECK(header.width_px == 5);
  CHECK(header.height_px == 4);
  CHECK(header.bit_depth == 16);
  CHECK(std::string(header.colour) == "grey");

  // 16-bit samples stand most significant byte first on disk: a file of another machine reads the same.
  CHECK(read_grey16_png(folder / "grey16.png").at(1, 0) == 3401);
  CHECK_THAT(complaint(ExitCode::kBadFile, [&] { (void)read_grey_png(folder / "rgb.png"); }),
             Contains("no good 8-bit grey PNG") && Contains("3x2, 8-bit RGB"));
}

TEST_CASE("a damaged PNG is refused at each length") {
  if (!png_available()) return;
  const TemporaryFolder folder;
  write_png(folder / "whole.png", Grey16Picture(40, 30, 1234));
  const std::string whole = read_text_file(folder / "whole.png");
  for (std::size_t size = 0; size < whole.size(); ++size) {
    write_text_file(folder / "cut.png", whole.substr(0, size));
    CHECK_THROWS_AS((void)read_grey16_png(folder / "cut.png"), Error);
  }
  for (std::size_t at = 0; at < whole.size(); ++at) {
    std::string changed = whole;
    changed[at] = static_cast<char>(changed[at] ^ 0x55);
    write_text_file(folder / "changed.png", changed);
    try {
      (void)read_grey16_png(folder / "changed.png");
    } catch (const Error&) {
    }
  }
}

TEST_CASE("a missing or wrong file is named") {
  const TemporaryFolder folder;
  CHECK_THAT(complaint(ExitCode::kFile, [&] { (void)png_header(folder / "none.png"); }),
             Contains("none.png: cannot be opened"));
  write_text_file(folder / "text.png", "this is surely no picture at all");
  CHECK_THAT(complaint(ExitCode::kBadFile, [&] { (void)png_header(folder / "text.png"); }),
             Contains("is no PNG file"));
  if (!png_available()) {
    CHECK_THAT(complaint(ExitCode::kFile, [&] { write_png(folder / "a.png", GreyPicture(1, 1)); }),
               Contains("libpng"));
    return;
  }
  CHECK_THAT(
      complaint(ExitCode::kFile, [&] { write_png(folder.path() / "no" / "a.png", GreyPicture(1, 1)); }),
      Contains("cannot be written"));
}
