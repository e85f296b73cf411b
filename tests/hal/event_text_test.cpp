#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "evt_printing.hpp"
#include "hal/event_text_decoder.hpp"

using namespace egofocus;
using Events = std::vector<Event>;

namespace {

// As a caller with a small buffer does it: the tail of each piece is brought again with the next.
Events decode(EventTextDecoder& decoder, const std::string& text, std::size_t room = 8,
              std::size_t cut = SIZE_MAX) {
  Events events;
  Events out(room);
  const std::span<const std::byte> all = std::as_bytes(std::span(text));
  std::size_t taken = 0;
  std::size_t seen = 0;
  const auto keep = [&](const Decoded& done) {
    taken += done.consumed;
    events.insert(events.end(), out.begin(), out.begin() + static_cast<std::ptrdiff_t>(done.produced));
  };
  while (seen < all.size()) {
    seen = cut < all.size() - seen ? seen + cut : all.size();
    for (Decoded done{1, 0}; done.consumed > 0;) {
      done = decoder.feed(all.subspan(taken, seen - taken), out);
      keep(done);
    }
  }
  while (taken < all.size()) keep(decoder.finish(all.subspan(taken), out));
  return events;
}

Events decode(const std::string& text) {
  EventTextDecoder decoder({240, 180});
  return decode(decoder, text);
}

}  // namespace

TEST_CASE("event text: plain lines") {
  CHECK(decode("0.003811000 96 133 0\n0.003820001 87 51 1\n") ==
        Events{{3811, 96, 133, 0}, {3820, 87, 51, 1}});
}

TEST_CASE("event text: line ends, blanks, comments, signs and a last line without end") {
  CHECK(decode("# t x y p\r\n\r\n  1.0\t2   3 -1 \r\n \n+2 4 5 1") ==
        Events{{1'000'000, 2, 3, 0}, {2'000'000, 4, 5, 1}});
}

TEST_CASE("event text: seconds become the nearest microsecond, exactly") {
  struct Case {
    const char* seconds;
    std::int64_t t_us;
  };
  const Case cases[] = {
      {"0", 0},
      {"1.0000004999999999999999", 1'000'000},
      {"1.0000005", 1'000'001},
      {"0.00000049", 0},
      {"0.00000005", 0},
      {".0000005", 1},
      {"-0.0000005", -1},
      {"-1.5", -1'500'000},
      {"1468939993.067416", 1'468'939'993'067'416},
      {"1.468939993067416000e+09", 1'468'939'993'067'416},
      {"25e-6", 25},
      {"9223372036854.775807", INT64_MAX},
  };
  for (const Case& c : cases) {
    CAPTURE(c.seconds);
    CHECK(decode(std::string(c.seconds) + " 1 2 1\n") == Events{{c.t_us, 1, 2, 1}});
  }
}

TEST_CASE("event text: pixels and polarity may be written as decimals") {
  CHECK(decode("1 1.2e+01 100.000 1.0\n1 0.0 0e5 -1.000\n") ==
        Events{{1'000'000, 12, 100, 1}, {1'000'000, 0, 0, 0}});
}

TEST_CASE("event text: what is not an event is counted") {
  EventTextDecoder decoder({240, 180});
  const Events events = decode(decoder,
                               "240 180\n"              // malformed: two words
                               "1 2 3 1 5\n"            // five
                               "1 2 3 2\n"              // polarity
                               "1 2.5 3 1\n"            // half a pixel
                               "x 2 3 1\n1s 2 3 1\n"    // not numbers
                               "9223372036855 2 3 1\n"  // beyond int64
                               "1 99999999999999999999 3 1\n"
                               "2 240 0 1\n2 0 180 1\n2 -1 0 1\n"  // outside
                               "3 1 1 1\n2 1 1 1\n" +              // out of order
                                   std::string(600, '1') +
                                   "\n4 1 1 0\n#\n");
  CHECK(events.size() == 3);
  const EventTextCounters& counters = decoder.counters();
  CHECK(counters.lines == 16);
  CHECK(counters.malformed == 8);
  CHECK(counters.out_of_range == 3);
  CHECK(counters.out_of_order == 1);
  CHECK(counters.over_long == 1);
  CHECK(counters.blank == 1);
  CHECK(counters.events == 3);
}

TEST_CASE("event text: neither cuts of the input nor small outputs change anything") {
  const std::string text = "0.1 1 2 1\r\n# c\n0.2 3 4 0\nbad\n0.3 5 6 1";
  const Events whole = decode(text);
  REQUIRE(whole.size() == 3);
  for (std::size_t cut = 1; cut <= text.size(); ++cut) {
    for (std::size_t room = 1; room <= 4; ++room) {
      EventTextDecoder decoder({240, 180});
      CHECK(decode(decoder, text, room, cut) == whole);
      CHECK(decoder.counters().lines == 5);
    }
  }
}
