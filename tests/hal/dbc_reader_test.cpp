#include <catch2/catch.hpp>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "hal/dbc.hpp"
#include "hal/dbc_files.hpp"

using namespace egofocus;

namespace {

const std::string kMessage = "BO_ 100 M: 8 X\n";

// A file of one message with these signal lines.
std::string with(const std::string& lines) {
  return "VERSION \"\"\n" + kMessage + lines + "\n";
}

void check_refused(const std::string& text, std::int64_t line, const std::string& reason) {
  INFO(text);
  auto dbc = std::make_unique<Dbc>();
  const Status status = read_dbc(text, {}, *dbc);
  CHECK(status.code() == StatusCode::kParse);
  CHECK(status.value() == line);
  CHECK(std::string(status.subject()).find(reason) != std::string::npos);
  CHECK(dbc->message_count == 0);
  CHECK(dbc->signal_count == 0);
}

bool present(const Dbc& dbc, const char* name, const std::vector<int>& bytes) {
  const std::vector<std::uint8_t> data(bytes.begin(), bytes.end());
  const DbcSignal* signal = dbc.find_signal(dbc.messages[0], name);
  REQUIRE(signal != nullptr);
  return is_present(dbc, *signal, data);
}

}  // namespace

TEST_CASE("dbc: layout, factor, extended id, Latin-1, CRLF, comments over lines") {
  const auto dbc = read_dbc_text(
      "VERSION \"x\"\r\nNS_ :\r\n\tCM_\r\n\tSIG_VALTYPE_\r\n\tSG_MUL_VAL_\r\nBS_:\r\nBU_: A B\r\n\r\n"
      "BO_ 2565876352 ARI : 8 A\r\n"
      "  SG_ Pitch:0|16@1+(0.0078125,-2.5E2)[-250|250.99] \"\xB0/s\" B\r\n"
      " SG_ Y : 23 | 16 @ 0 - ( -1e-05 , +0 ) [0|0] \"\" A,B\r\n"
      "CM_ \"first\r\nBO_ 1 NotAMessage: 8 A\r\nwith \\\"quotes\\\" in it\";\r\n"
      "VAL_ 2565876352 Y 0 \"SG_ no\" 1 \"b\" ;\r\n"
      "BO_ 3221225472 VECTOR__INDEPENDENT_SIG_MSG: 0 Vector__XXX\r\n SG_ Orphan : 0|8@1+ (1,0) [0|0] \"\" "
      "X\r\n"
      "BO_ 2047 Last: 64 B");
  REQUIRE(dbc->message_count == 2);
  const DbcMessage* ari = dbc->find_message("ARI");
  REQUIRE(ari != nullptr);
  CHECK(ari->id == 0x18F02A80);
  CHECK(ari->extended);
  CHECK(ari->length == 8);
  CHECK(ari->signal_count == 2);
  const DbcSignal* pitch = dbc->find_signal(*ari, "Pitch");
  REQUIRE(pitch != nullptr);
  CHECK(pitch->start_bit == 0);
  CHECK(pitch->length_bits == 16);
  CHECK_FALSE(pitch->motorola);
  CHECK(pitch->number == DbcSignal::Number::kUnsigned);
  CHECK(pitch->factor == 0.0078125);
  CHECK(pitch->offset == -250.0);
  const DbcSignal* y = dbc->find_signal(*ari, "Y");
  REQUIRE(y != nullptr);
  CHECK(y->motorola);
  CHECK(y->number == DbcSignal::Number::kSigned);
  CHECK(y->factor == -1e-05);
  const DbcMessage* last = dbc->find_message("Last");
  REQUIRE(last != nullptr);
  CHECK_FALSE(last->extended);
  CHECK(last->length == 64);
  CHECK(dbc->find_message("Las") == nullptr);
  CHECK(dbc->find_signal(*last, "Y") == nullptr);
}

TEST_CASE("dbc: only wanted messages count and are checked") {
  std::string text;
  for (int i = 1; i <= 500; ++i) {
    text += "BO_ " + std::to_string(i) + " M" + std::to_string(i) +
            ": 8 X\n SG_ S : 0|99@1+ (0,0) [0|0] \"\" X\n";
  }
  text +=
      "BO_ 501 Good: 8 X\n SG_ S : 0|8@1+ (1,0) [0|0] \"\" X\nSG_MUL_VAL_ 7 S S 1-1;\nSIG_VALTYPE_ 8 S : "
      "1;\n";
  auto dbc = std::make_unique<Dbc>();
  const std::string_view wanted[] = {"Good", "Absent"};
  REQUIRE(read_dbc(text, wanted, *dbc).ok());
  CHECK(dbc->message_count == 1);
  CHECK(dbc->signal_count == 1);
}

TEST_CASE("dbc: plain multiplexing") {
  const auto dbc =
      read_dbc_text(with(" SG_ A m0 : 8|8@1+ (1,0) [0|0] \"\" X\n SG_ Mux M : 0|8@1+ (1,0) [0|0] \"\" X\n"
                         " SG_ B m7 : 8|8@1+ (1,0) [0|0] \"\" X\n SG_ C : 16|8@1+ (1,0) [0|0] \"\" X"));
  CHECK(present(*dbc, "A", {0, 1, 2}));
  CHECK_FALSE(present(*dbc, "B", {0, 1, 2}));
  CHECK(present(*dbc, "B", {7, 1, 2}));
  CHECK_FALSE(present(*dbc, "A", {7, 1, 2}));
  CHECK(present(*dbc, "C", {7, 1, 2}));
  CHECK(present(*dbc, "Mux", {7, 1, 2}));
  CHECK_FALSE(present(*dbc, "A", {}));
}

TEST_CASE("dbc: extended multiplexing") {
  const auto dbc =
      read_dbc_text(with(" SG_ Top M : 0|8@1+ (1,0) [0|0] \"\" X\n SG_ Sub m1M : 8|8@1+ (1,0) [0|0] \"\" X\n"
                         " SG_ Deep m2 : 16|8@1+ (1,0) [0|0] \"\" X\n"
                         " SG_ Wide m0 : 24|8@1+ (1,0) [0|0] \"\" X\n"
                         "SG_MUL_VAL_ 100 Sub Top 1-1;\nSG_MUL_VAL_ 100 Deep Sub 2-4, 9-9;\n"
                         "SG_MUL_VAL_ 100 Wide Top 0-0,3-5 ;"));
  CHECK(present(*dbc, "Sub", {1, 0, 0, 0}));
  CHECK_FALSE(present(*dbc, "Sub", {2, 0, 0, 0}));
  for (const int value : {2, 3, 4, 9}) CHECK(present(*dbc, "Deep", {1, value, 0, 0}));
  for (const int value : {1, 5, 8, 10}) CHECK_FALSE(present(*dbc, "Deep", {1, value, 0, 0}));
  CHECK_FALSE(present(*dbc, "Deep", {0, 2, 0, 0}));  // its multiplexer is not there
  for (const int value : {0, 3, 5}) CHECK(present(*dbc, "Wide", {value, 0, 0, 0}));
  for (const int value : {1, 2, 6}) CHECK_FALSE(present(*dbc, "Wide", {value, 0, 0, 0}));
}

TEST_CASE("dbc: value types") {
  const auto dbc =
      read_dbc_text(with(" SG_ F : 7|32@0- (1,0) [0|0] \"\" X\n SG_ I : 39|32@0- (1,0) [0|0] \"\" X\n"
                         "SIG_VALTYPE_ 100 F :1;\nSIG_VALTYPE_ 100 I : 0;"));
  CHECK(dbc->signals[0].number == DbcSignal::Number::kFloat32);
  CHECK(dbc->signals[1].number == DbcSignal::Number::kSigned);
  const auto wide = read_dbc_text(with(" SG_ D : 0|64@1- (1,0) [0|0] \"\" X\nSIG_VALTYPE_ 100 D 2;"));
  CHECK(wide->signals[0].number == DbcSignal::Number::kFloat64);
}

TEST_CASE("dbc: bad files are refused with line and reason") {
  const std::string tail = " [0|0] \"\" X";
  check_refused("", 1, "not a DBC");
  check_refused("hello\nworld\n", 2, "not a DBC");
  check_refused(" SG_ A : 0|8@1+ (1,0)" + tail, 1, "without a BO_");
  check_refused("BO_ x M: 8 X", 1, "id");
  check_refused("BO_ 4294967296 M: 8 X", 1, "id");
  check_refused("BO_ 2048 M: 8 X", 1, "11 or 29");
  check_refused("BO_ 3000000000 M: 8 X", 1, "11 or 29");
  check_refused("BO_ 1 M 8 X", 1, "colon");
  check_refused("BO_ 1 M: 65 X", 1, "64 bytes");
  check_refused("BO_ 1 M: X", 1, "length");
  check_refused("BO_ 1 " + std::string(64, 'n') + ": 8 X", 1, "63");
  check_refused("BO_ 1 M: 8 X\nBO_ 1 N: 8 X", 2, "same id");
  check_refused("BO_ 1 M: 8 X\nBO_ 2 M: 8 X", 2, "same name");
  check_refused(with(" SG_ : 0|8@1+ (1,0)" + tail), 3, "needs a name");
  check_refused(with(" SG_ A 0|8@1+ (1,0)" + tail), 3, "multiplexing code");
  check_refused(with(" SG_ A mM : 0|8@1+ (1,0)" + tail), 3, "multiplexing code");
  check_refused(with(" SG_ A : 0|0@1+ (1,0)" + tail), 3, "0 or more than 64");
  check_refused(with(" SG_ A : 0|65@1+ (1,0)" + tail), 3, "0 or more than 64");
  check_refused(with(" SG_ A : 1|64@1+ (1,0)" + tail), 3, "beyond the end");
  check_refused(with(" SG_ A : 6|64@0+ (1,0)" + tail), 3, "beyond the end");
  check_refused(with(" SG_ A : 64|1@1+ (1,0)" + tail), 3, "beyond the end");
  check_refused(with(" SG_ A : 4294967295|1@1+ (1,0)" + tail), 3, "beyond the end");
  check_refused(with(" SG_ A : 0|8@2+ (1,0)" + tail), 3, "order");
  check_refused(with(" SG_ A : 0|8@1 (1,0)" + tail), 3, "+ or -");
  check_refused(with(" SG_ A : 0|8@1+ (0,0)" + tail), 3, "factor of 0");
  check_refused(with(" SG_ A : 0|8@1+ (1;0)" + tail), 3, "(factor,offset)");
  check_refused(with(" SG_ A : 0|8@1+ (1e999,0)" + tail), 3, "(factor,offset)");
  check_refused(with(" SG_ A : 0|8@1+ (1,0)" + tail + "\n SG_ A : 0|8@1+ (1,0)" + tail), 4, "same name");
  check_refused(with(" SG_ A m1 : 0|8@1+ (1,0)" + tail) + "BO_ 2 N: 1 X\n", 4, "no multiplexer");
  check_refused(with(" SG_ A : 0|8@1+ (1,0)" + tail + "\nSIG_VALTYPE_ 100 A : 1;"), 4, "32 bits");
  check_refused(with(" SG_ A : 0|8@1+ (1,0)" + tail + "\nSIG_VALTYPE_ 100 B : 1;"), 4, "no such signal");
  check_refused(with(" SG_ A : 0|8@1+ (1,0)" + tail + "\nSG_MUL_VAL_ 100 A A 1-1;"), 4, "no multiplexer");
  check_refused(with(" SG_ A M : 0|8@1+ (1,0)" + tail + "\nSG_MUL_VAL_ 100 A A 2-1;"), 4, "ranges");
  check_refused(with(" SG_ A M : 0|8@1+ (1,0)" + tail + "\nSG_MUL_VAL_ 100 A A 1-1, 2-2, 3-3, 4-4, 5-5;"), 4,
                "more than 4");
  check_refused(with(" SG_ A M : 0|8@1+ (1,0)" + tail + "\nSG_MUL_VAL_ 100 A A 1-1;\n"), 5, "circle");
  check_refused(with("CM_ \"never\nends"), 3, "closing quote");

  std::string many;
  for (int i = 1; i <= 65; ++i) many += "BO_ " + std::to_string(i) + " M" + std::to_string(i) + ": 8 X\n";
  check_refused(many, 65, "more than 64 messages");
  many = kMessage;
  for (int i = 1; i <= 257; ++i) many += " SG_ S" + std::to_string(i) + " : 0|8@1+ (1,0)" + tail + "\n";
  check_refused(many, 258, "more than 256 signals");
}

TEST_CASE("dbc: the shipped files read completely") {
  struct Expected {
    const char* file;
    std::size_t messages;
    std::size_t signals;
  };
  for (const Expected& expected :
       {Expected{"bosch_mm.dbc", 3, 19}, Expected{"j1939_imu.dbc", 4, 24}, Expected{"xsens_mti.dbc", 10, 22},
        Expected{"racelogic_imu03.dbc", 4, 7}, Expected{"wheels_examples.dbc", 8, 22},
        Expected{"bosch_abs_m5.dbc", 4, 9}}) {
    const auto dbc = read_shipped_dbc(expected.file);
    INFO(expected.file);
    CHECK(dbc->message_count == expected.messages);
    CHECK(dbc->signal_count == expected.signals);
  }
}

TEST_CASE("dbc: VFrameFormat says which messages are J1939 parameter groups") {
  const std::string messages =
      "BO_ 2364540158 A: 8 X\n SG_ S : 0|8@1+ (1,0) [0|0] \"\" X\nBO_ 2565876352 B: 8 X\nBO_ 7 C: 8 X\n";
  const auto groups = [&](const std::string& attributes) {
    const auto dbc = read_dbc_text(messages + attributes);
    std::string which;
    for (std::size_t i = 0; i < dbc->message_count; ++i)
      if (dbc->messages[i].parameter_group) which += dbc->messages[i].name;
    return which;
  };
  CHECK(groups("") == "");
  CHECK(groups("BA_ \"VFrameFormat\" BO_ 2565876352 3;\n") == "B");
  CHECK(groups("BA_DEF_DEF_ \"VFrameFormat\" \"J1939PG\";\n") == "AB");  // no 11-bit id is one
  CHECK(groups("BA_DEF_DEF_ \"VFrameFormat\" \"J1939PG\";\nBA_ \"VFrameFormat\" BO_ 2565876352 1;\n") == "A");
  CHECK(groups("BA_DEF_DEF_ \"VFrameFormat\" \"StandardCAN\";\nBA_ \"VFrameFormat\" BO_ 7 3;\n") == "");
  CHECK(groups("BA_ \"VFrameFormat\" BO_ 12345 3;\nBA_ \"Other\" BO_ 2565876352 3;\nBA_ \"Other\" 5;\n") ==
        "");
  CHECK(groups("BA_ \"VFrameFormat\nBO_ 2565876352 3;\";\n") == "");
  auto dbc = std::make_unique<Dbc>();
  CHECK_FALSE(read_dbc(messages + "BA_ \"VFrameFormat\" BO_ x;\n", {}, *dbc).ok());
}
