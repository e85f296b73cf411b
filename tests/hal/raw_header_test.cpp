#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "hal/raw_header.hpp"

using namespace egofocus;

namespace {

Status parse(const std::string& text, RawHeader& header) {
  return parse_raw_header(std::as_bytes(std::span(text)), header);
}

RawHeader parsed(const std::string& text) {
  RawHeader header;
  const Status status = parse(text, header);
  CAPTURE(text, status.subject(), status.value());
  REQUIRE(status.ok());
  return header;
}

}  // namespace

TEST_CASE("RAW header: of an EVK4") {
  const std::string text =
      "% camera_integrator_name Prophesee\n% date 2024-02-22 10:24:42\n% evt 3.0\n% format "
      "EVT3;height=720;width=1280\n"
      "% generation 4.2\n% geometry 1280x720\n% sensor_name IMX636\n% serial_number 00000157\n% end\nEVENTS";
  const RawHeader header = parsed(text);
  CHECK(header.format == EvtFormat::kEvt3);
  CHECK(header.size.width_px == 1280);
  CHECK(header.size.height_px == 720);
  CHECK(std::string(header.sensor_name) == "IMX636");
  CHECK(std::string(header.serial_number) == "00000157");
  CHECK(std::string(header.date) == "2024-02-22 10:24:42");
  CHECK(text.substr(header.header_bytes) == "EVENTS");
}

TEST_CASE("RAW header: an old one ends at the first line of another kind") {
  const RawHeader header = parsed("% evt 2.0\r\n% plugin_name hal_plugin_gen3_fx3\r\n\x01\x02\x03");
  CHECK(header.format == EvtFormat::kEvt2);
  CHECK(header.size.width_px == 640);
  CHECK(header.header_bytes == 46);
}

TEST_CASE("RAW header: precedence") {
  SECTION("format over evt, its size over geometry") {
    const RawHeader header =
        parsed("% format EVT3;height=10;width=20\n% evt 2.0\n% geometry 1280x720\n% end\n");
    CHECK(header.format == EvtFormat::kEvt3);
    CHECK(header.size.width_px == 20);
    CHECK(header.size.height_px == 10);
  }
  SECTION("geometry over the sensor's name") {
    CHECK(parsed("% evt 3.0\n% sensor_name IMX636\n% geometry 64x48\n% end\n").size.width_px == 64);
  }
  SECTION("the sensor's name where nothing else is said") {
    CHECK(parsed("% evt 3.0\n% sensor_name GenX320\n% end\n").size.height_px == 320);
    CHECK(parsed("% evt 3.0\n% sensor_name IMX636\n% end\n").size.height_px == 720);
    CHECK(parsed("% evt 3.0\n% sensor_generation 3.1\n% end\n").size.width_px == 640);
  }
}

TEST_CASE("RAW header: EVT2.1 is legacy unless it says otherwise") {
  CHECK(parsed("% evt 2.1\n% geometry 8x8\n% end\n").format == EvtFormat::kEvt21Legacy);
  CHECK(parsed("% format EVT21;width=8;height=8;endianness=legacy\n% end\n").format ==
        EvtFormat::kEvt21Legacy);
  CHECK(parsed("% format EVT21;width=8;height=8;endianness=little\n% end\n").format == EvtFormat::kEvt21);
  CHECK(parsed("% endianness little\n% evt 2.1\n% geometry 8x8\n% end\n").format == EvtFormat::kEvt21);
}

TEST_CASE("RAW header: each fault is named with its line") {
  struct Case {
    std::string text;
    StatusCode code;
    std::int64_t line;
  };
  const Case cases[] = {
      {"", StatusCode::kBadHeader, 1},
      {"%evt 3.0\n", StatusCode::kBadHeader, 1},
      {"% evt 3.0\n% geometry 640x480", StatusCode::kBadHeader, 2},
      {"% geometry 640x480\n% end\n", StatusCode::kBadHeader, 2},
      {"% evt 3.0\n% end\n", StatusCode::kBadHeader, 2},
      {"% evt 3.0\n% geometry 640\n% end\n", StatusCode::kBadHeader, 2},
      {"% evt 3.0\n% geometry 0x480\n% end\n", StatusCode::kBadHeader, 2},
      {"% evt 3.0\n% geometry 99999999999x480\n% end\n", StatusCode::kBadHeader, 2},
      {"% x\n% format EVT3;width=-1;height=5\n% end\n", StatusCode::kBadHeader, 2},
      {"% format EVT4;width=10;height=5\n% end\n", StatusCode::kUnsupportedFormat, 1},
      {"% evt 4.0\n", StatusCode::kUnsupportedFormat, 1},
      {"% endianness big\n", StatusCode::kUnsupportedFormat, 1},
      {"% " + std::string(5000, 'x') + "\n% end\n", StatusCode::kBadHeader, 1},
  };
  for (const Case& c : cases) {
    RawHeader header;
    const Status status = parse(c.text, header);
    CAPTURE(c.text, status.subject());
    CHECK(status.code() == c.code);
    CHECK(status.value() == c.line);
  }
  std::string endless;
  for (int i = 0; i < 1000; ++i) endless += "% key value\n";
  RawHeader header;
  CHECK(parse(endless, header).code() == StatusCode::kBadHeader);
}

TEST_CASE("RAW header: what is written reads back") {
  RawHeader header;
  header.format = GENERATE(EvtFormat::kEvt2, EvtFormat::kEvt21, EvtFormat::kEvt21Legacy, EvtFormat::kEvt3);
  header.size = {2048, 2047};
  std::fill_n(header.sensor_name, 31, 's');
  std::fill_n(header.serial_number, 31, '7');
  std::fill_n(header.date, 31, '2');
  std::vector<std::byte> bytes(kMaxWrittenRawHeaderBytes);
  const std::size_t size = write_raw_header(header, bytes);
  REQUIRE(size > 0);
  RawHeader back;
  REQUIRE(parse_raw_header(std::span(bytes).first(size), back).ok());
  CHECK(back.format == header.format);
  CHECK(back.size.width_px == 2048);
  CHECK(back.size.height_px == 2047);
  CHECK(std::string(back.sensor_name) == header.sensor_name);
  CHECK(std::string(back.serial_number) == header.serial_number);
  CHECK(std::string(back.date) == header.date);
  CHECK(back.header_bytes == size);
  CHECK(write_raw_header(header, std::span(bytes).first(size - 1)) == 0);
}
