#include <catch2/catch.hpp>
#include <cstring>
#include <string>
#include <vector>

#include "hal/candump_decoder.hpp"
#include "hal/candump_writer.hpp"

using namespace egofocus;

namespace {

struct Result {
  std::vector<CanFrame> frames;
  CandumpCounters counters;
};

// Feeds in pieces that end at each of `cuts`, as a reader of a file would: what was not consumed is brought
// again.
Result decode(const std::string& text, const std::vector<std::size_t>& cuts = {}, std::size_t room = 4) {
  Result result;
  CandumpDecoder decoder;
  std::vector<CanFrame> out(room);
  std::vector<std::size_t> ends = cuts;
  ends.push_back(text.size());
  std::size_t at = 0;
  for (std::size_t i = 0; i < ends.size(); ++i) {
    const bool last = i + 1 == ends.size();
    for (;;) {
      const auto bytes = std::as_bytes(std::span(text.data() + at, ends[i] - at));
      const Decoded done = last ? decoder.finish(bytes, out) : decoder.feed(bytes, out);
      result.frames.insert(result.frames.end(), out.begin(),
                           out.begin() + static_cast<std::ptrdiff_t>(done.produced));
      at += done.consumed;
      if (done.consumed == 0) break;
    }
  }
  CHECK(at == text.size());
  result.counters = decoder.counters();
  return result;
}

CanFrame only(const std::string& line) {
  const Result result = decode(line);
  REQUIRE(result.frames.size() == 1);
  return result.frames[0];
}

std::string bytes_of(const CanFrame& frame) {
  return std::string(reinterpret_cast<const char*>(frame.data), frame.length);
}

const std::string kAllForms =
    "(1436509052.249713) vcan0 044#2A366C2BBA\n"
    "(1436509052.249714123) can0 18F02A80#00.7D.00.7D.00.7D.FF.FF R\r\n"
    "\n"
    "(1436509052.249715) can0 123##1A0B1C2\n"
    "(1436509052.249716) can0 123#R\n"
    "(1436509052.249717) can0 123#R3 T\n"
    "(1436509052.249718) can0 20000004#0001000000000000\n"
    "(1436509052.249719) can0 7FF#1122334455667788_9\n"
    "DROPCOUNT: dropped 3 CAN frames on 'can0' socket (total drops 3)\n"
    "(1436509052.249700) can0 001#\n"
    "can0  123   [8]  11 22 33 44 55 66 77 88\n"
    "(1436509052.249720) can0 242#81:00:12345678#11223344.556677\n"
    "(1436509052.249721) can0 1FFFFFFF#aB";

}  // namespace

TEST_CASE("candump: a classic frame") {
  const CanFrame frame = only("(1436509052.249713) vcan0 044#2A366C2BBA\n");
  CHECK(frame.t_us == 1436509052249713);
  CHECK(frame.id == 0x44);
  CHECK_FALSE(frame.extended);
  CHECK_FALSE(frame.fd);
  CHECK(bytes_of(frame) == "\x2A\x36\x6C\x2B\xBA");
}

TEST_CASE("candump: every form, and every line counted once") {
  const Result result = decode(kAllForms);
  const CandumpCounters& n = result.counters;
  REQUIRE(result.frames.size() == 6);
  CHECK(n.lines == 13);
  CHECK(n.frames == 6);
  CHECK(n.blank == 1);
  CHECK(n.remote_frames == 2);
  CHECK(n.error_frames == 1);
  CHECK(n.drop_notices == 1);
  CHECK(n.recorder_drops == 3);
  CHECK(n.unknown == 2);
  CHECK(n.over_long == 0);
  CHECK(n.out_of_order == 1);
  CHECK(n.frames + n.error_frames + n.remote_frames + n.drop_notices + n.blank + n.unknown + n.over_long ==
        n.lines);

  CHECK(result.frames[1].t_us == 1436509052249714);
  CHECK(result.frames[1].extended);
  CHECK(result.frames[1].id == 0x18F02A80);
  CHECK(result.frames[1].length == 8);
  CHECK(result.frames[1].data[1] == 0x7D);
  CHECK(result.frames[2].fd);
  CHECK(bytes_of(result.frames[2]) == "\xA0\xB1\xC2");
  CHECK(result.frames[3].length == 8);
  CHECK(result.frames[4].length == 0);
  CHECK(result.frames[5].id == 0x1FFFFFFF);
  CHECK(bytes_of(result.frames[5]) == "\xAB");
}

TEST_CASE("candump: the cut between two pieces does not matter") {
  const Result whole = decode(kAllForms);
  for (std::size_t cut = 0; cut <= kAllForms.size(); ++cut) {
    const Result split = decode(kAllForms, {cut}, 1);
    REQUIRE(split.frames.size() == whole.frames.size());
    for (std::size_t i = 0; i < whole.frames.size(); ++i) {
      CHECK(split.frames[i].t_us == whole.frames[i].t_us);
      CHECK(split.frames[i].id == whole.frames[i].id);
      CHECK(std::memcmp(split.frames[i].data, whole.frames[i].data, 64) == 0);
    }
    CHECK(std::memcmp(&split.counters, &whole.counters, sizeof(CandumpCounters)) == 0);
  }
}

TEST_CASE("candump: a line without an end is left until finish") {
  CandumpDecoder decoder;
  CanFrame out[2];
  const std::string text = "(1.000000) can0 123#11";
  const auto bytes = std::as_bytes(std::span(text.data(), text.size()));
  Decoded done = decoder.feed(bytes, out);
  CHECK(done.consumed == 0);
  CHECK(done.produced == 0);
  done = decoder.finish(bytes, out);
  CHECK(done.consumed == text.size());
  CHECK(done.produced == 1);
}

TEST_CASE("candump: malformed lines are unknown") {
  for (const char* line : {"(1.000000) can0 123#1",
                           "(1.000000) can0 123#112233445566778899",
                           "(1.000000) can0 800#11",
                           "(1.000000) can0 12#11",
                           "(1.000000) can0 1234#11",
                           "(1.00000) can0 123#11",
                           "(1.0000000) can0 123#11",
                           "(-1.000000) can0 123#11",
                           "1.000000 can0 123#11",
                           "(1.000000) 123#11",
                           "(1.000000) can0 123#11 X",
                           "(1.000000) can0 123#11 R T",
                           "(1.000000) can0 123#11.",
                           "(1.000000) can0 123#11..22",
                           "(1.000000) can0 123#G1",
                           "(1.000000) can0 12G#11",
                           "(1.000000) can0 123#11_9",
                           "(1.000000) can0 123#1122334455667788_8",
                           "(1.000000) can0 123##",
                           "(1.000000) can0 123##G11",
                           "(1.000000) can0 123#R9",
                           "(1.000000) can0 123#R3_9",
                           "(1.000000) can0",
                           "(1.000000)",
                           "(99999999999999.000000) can0 123#11",
                           "(.000000) can0 123#11",
                           "()",
                           "(1.000000) can0 123"}) {
    const Result result = decode(line);
    INFO(line);
    CHECK(result.frames.empty());
    CHECK(result.counters.unknown == 1);
  }
}

TEST_CASE("candump: FD holds 64 bytes and no more") {
  std::string digits;
  for (int i = 0; i < 64; ++i) digits += "5A";
  CHECK(only("(1.000000) can0 123##0" + digits).length == 64);
  CHECK(decode("(1.000000) can0 123##0" + digits + "00").counters.unknown == 1);
}

TEST_CASE("candump: an over-long line is counted once and forgotten") {
  const std::string text =
      "(1.000000) can0 123#11\n" + std::string(100000, 'x') + "\n(2.000000) can0 123#22\n";
  for (const std::size_t step : {std::size_t{513}, std::size_t{1000}, std::size_t{70000}, text.size()}) {
    std::vector<std::size_t> cuts;
    for (std::size_t at = step; at < text.size(); at += step) cuts.push_back(at);
    const Result result = decode(text, cuts);
    CHECK(result.frames.size() == 2);
    CHECK(result.counters.over_long == 1);
    CHECK(result.counters.lines == 3);
  }
}

TEST_CASE("candump: what the writer writes, the decoder reads") {
  std::string text;
  std::vector<CanFrame> frames;
  for (int i = 0; i < 40; ++i) {
    CanFrame frame;
    frame.t_us = 1700000000000000 + i * 1234567;
    frame.fd = i % 3 == 0;
    frame.extended = i % 2 == 0;
    frame.id = frame.extended ? 0x1FFFFFFFu - static_cast<unsigned>(i) : static_cast<unsigned>(i);
    frame.length = static_cast<std::uint8_t>(frame.fd ? 64 - i : i % 9);
    for (std::uint8_t b = 0; b < frame.length; ++b) frame.data[b] = static_cast<std::uint8_t>(b * 37 + i);
    frames.push_back(frame);
    char line[kMaxCandumpLineBytes];
    const std::size_t n = write_candump_line(frame, "can0", line);
    REQUIRE(n > 0);
    for (std::size_t small = 0; small < n; ++small)
      CHECK(write_candump_line(frame, "can0", std::span(line, small)) == 0);
    REQUIRE(write_candump_line(frame, "can0", std::span(line, n)) == n);
    text.append(line, n);
  }
  const Result result = decode(text);
  REQUIRE(result.frames.size() == frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    CHECK(result.frames[i].t_us == frames[i].t_us);
    CHECK(result.frames[i].id == frames[i].id);
    CHECK(result.frames[i].extended == frames[i].extended);
    CHECK(result.frames[i].fd == frames[i].fd);
    CHECK(bytes_of(result.frames[i]) == bytes_of(frames[i]));
  }
}

TEST_CASE("candump: the writer's text, and what it refuses") {
  CanFrame frame;
  frame.t_us = 1249713;
  frame.id = 0x44;
  frame.length = 2;
  frame.data[0] = 0xA5;
  char line[kMaxCandumpLineBytes];
  const std::size_t n = write_candump_line(frame, "vcan0", line);
  CHECK(std::string(line, n) == "(0000000001.249713) vcan0 044#A500\n");
  CHECK(write_candump_line(frame, "", line) == 0);
  CHECK(write_candump_line(frame, "can 0", line) == 0);
  CHECK(write_candump_line(frame, "a-name-too-long-", line) == 0);
  frame.length = 9;
  CHECK(write_candump_line(frame, "can0", line) == 0);
  frame.length = 8;
  frame.id = 0x800;
  CHECK(write_candump_line(frame, "can0", line) == 0);
  frame.id = 1;
  frame.t_us = -1;
  CHECK(write_candump_line(frame, "can0", line) == 0);
  frame.t_us = INT64_MAX;
  frame.fd = true;
  frame.length = 64;
  frame.extended = true;
  CHECK(write_candump_line(frame, "can0123456789ab", line) > 0);
}
