// The grammar: one statement a line, known by its first word. What is not understood is skipped to the end of
// its line, where a text in quotes hides line ends; so comments, value tables and attributes need no rule of
// their own.
#include "hal/dbc.hpp"
#include "hal/dbc_text.hpp"

namespace egofocus {
namespace {

constexpr std::uint32_t kExtendedFlag = 0x80000000;
constexpr std::uint64_t kJ1939Format =
    3;  // of VFrameFormat: "StandardCAN","ExtendedCAN","reserved","J1939PG"
constexpr std::uint32_t kNoMessage = 0xC0000000;  // holds signals that belong to no message
constexpr std::string_view kFrameFormat = "VFrameFormat";

void copy_name(std::string_view name, char (&out)[kMaxDbcName + 1]) noexcept {
  for (std::size_t i = 0; i < name.size(); ++i) out[i] = name[i];
  out[name.size()] = '\0';
}

class Reader {
 public:
  Reader(std::string_view text, std::span<const std::string_view> wanted, Dbc& dbc) noexcept
      : text_(text), wanted_(wanted), dbc_(dbc) {}

  Status read() noexcept {
    while (!text_.at_end()) {
      statement_line_ = text_.line();
      if (!statement()) return failure();
      if (!text_.skip_line()) return fail("a text without its closing quote"), failure();
    }
    if (!in_message_) return fail("no BO_ line: this is not a DBC file"), failure();
    return close_message() && check_depth() ? Status{} : failure();
  }

 private:
  bool fail(const char* reason) noexcept {
    reason_ = reason;
    return false;
  }
  [[nodiscard]] Status failure() const noexcept { return {StatusCode::kParse, reason_, statement_line_}; }

  bool statement() noexcept {
    const std::string_view keyword = text_.word();
    if (text_.at_line_end()) return true;  // an empty line, or a keyword listed under NS_
    if (keyword == "BO_") return message();
    if (keyword == "SG_") return signal();
    if (keyword == "SG_MUL_VAL_") return multiplexer_values();
    if (keyword == "SIG_VALTYPE_") return value_type();
    if (keyword == "BA_") return attribute();
    if (keyword == "BA_DEF_DEF_") return attribute_default();
    return true;
  }

  [[nodiscard]] bool is_wanted(std::string_view name) const noexcept {
    for (const std::string_view w : wanted_) {
      if (w == name) return true;
    }
    return wanted_.empty();
  }

  // BO_ 2364540158 Name: 8 Sender
  bool message() noexcept {
    if (!close_message()) return false;
    in_message_ = true;
    std::uint64_t id = 0;
    if (!text_.whole(UINT32_MAX, id)) return fail("BO_ needs an id of at most 32 bits");
    const std::string_view name = text_.word();
    if (name.empty() || !text_.accept(':')) return fail("BO_ needs a name and a colon");
    if (id == kNoMessage || !is_wanted(name)) return true;

    std::uint64_t length = 0;
    if (!text_.whole(UINT32_MAX, length)) return fail("BO_ needs a length in bytes");
    if (length > 64) return fail("a message longer than 64 bytes");
    if (name.size() > kMaxDbcName) return fail("a name longer than 63 characters");
    if (dbc_.message_count == Dbc::kMaxMessages) return fail("more than 64 messages: name the wanted ones");
    if (find_id(id) != nullptr) return fail("a second message of the same id");
    if (dbc_.find_message(name) != nullptr) return fail("a second message of the same name");

    DbcMessage& added = dbc_.messages[dbc_.message_count];
    added = DbcMessage{};
    copy_name(name, added.name);
    added.extended = (id & kExtendedFlag) != 0;
    added.id = static_cast<std::uint32_t>(id & ~std::uint64_t{kExtendedFlag});
    if (added.id > (added.extended ? 0x1FFFFFFFu : 0x7FFu)) return fail("an id beyond its 11 or 29 bits");
    added.length = static_cast<std::uint8_t>(length);
    added.first_signal = static_cast<std::uint16_t>(dbc_.signal_count);
    ++dbc_.message_count;
    open_ = &added;
    return true;
  }

  // SG_ Name [M|m3|m3M] : 0|16@1+ (0.005,-163.84) [-163.84|163.835] "deg/s" Receiver
  bool signal() noexcept {
    if (!in_message_) return fail("SG_ without a BO_ before it");
    if (open_ == nullptr) return true;
    if (dbc_.signal_count == Dbc::kMaxSignals) return fail("more than 256 signals: name the wanted messages");
    DbcSignal& added = dbc_.signals[dbc_.signal_count];
    added = DbcSignal{};
    const std::string_view name = text_.word();
    if (name.empty()) return fail("SG_ needs a name");
    if (name.size() > kMaxDbcName) return fail("a name longer than 63 characters");
    if (dbc_.find_signal(*open_, name) != nullptr) return fail("a second signal of the same name");
    copy_name(name, added.name);
    if (!multiplexing(text_.word(), added)) return false;
    if (!text_.accept(':')) return fail("SG_ needs a colon after its name");
    if (!layout(added)) return false;
    if (!text_.accept('(') || !text_.real(added.factor) || !text_.accept(',') || !text_.real(added.offset) ||
        !text_.accept(')')) {
      return fail("SG_ needs (factor,offset)");
    }
    if (added.factor == 0) return fail("a factor of 0");
    ++dbc_.signal_count;
    ++open_->signal_count;
    return true;
  }

  bool multiplexing(std::string_view code, DbcSignal& added) noexcept {
    if (code.empty()) return true;
    added.is_multiplexer = code.back() == 'M';
    if (added.is_multiplexer) code.remove_suffix(1);
    if (code.empty()) return true;
    std::uint64_t value = 0;
    if (code.front() == 'm') {
      code.remove_prefix(1);
      if (DbcText::whole_in(code, UINT32_MAX, value)) {
        added.ranges[0] = {value, value};
        added.range_count = 1;
        return true;
      }
    }
    return fail("the multiplexing code is none of M, m3, m3M");
  }

  // 0|16@1+
  bool layout(DbcSignal& added) noexcept {
    std::uint64_t start = 0;
    std::uint64_t bits = 0;
    std::uint64_t intel = 0;
    if (!text_.whole(UINT32_MAX, start) || !text_.accept('|') || !text_.whole(UINT32_MAX, bits) ||
        !text_.accept('@') || !text_.whole(1, intel)) {
      return fail("SG_ needs start|length@order, order 0 or 1");
    }
    if (text_.accept('-')) {
      added.number = DbcSignal::Number::kSigned;
    } else if (!text_.accept('+')) {
      return fail("SG_ needs + or - after the order");
    }
    if (bits == 0 || bits > 64) return fail("a signal of 0 or more than 64 bits");
    const std::uint64_t bit = start % 8;
    const std::uint64_t before = start - bit + (intel == 1 ? bit : 7 - bit);
    if (before + bits > open_->length * std::uint64_t{8})
      return fail("a signal beyond the end of its message");
    added.start_bit = static_cast<std::uint16_t>(start);
    added.length_bits = static_cast<std::uint8_t>(bits);
    added.motorola = intel == 0;
    return true;
  }

  // SG_MUL_VAL_ 100 Signal Multiplexer 0-3, 7-7;
  bool multiplexer_values() noexcept {
    if (!close_message()) return false;  // its defaults come first
    DbcSignal* signal = nullptr;
    if (!known_signal(signal)) return false;
    if (signal == nullptr) return true;
    const DbcSignal* multiplexer = dbc_.find_signal(*message_of_, text_.word());
    if (multiplexer == nullptr || !multiplexer->is_multiplexer)
      return fail("SG_MUL_VAL_ names no multiplexer");
    signal->multiplexer = static_cast<std::int16_t>(multiplexer - dbc_.signals);
    signal->range_count = 0;
    do {
      DbcSignal::Range range;
      if (!text_.whole(UINT64_MAX, range.first) || !text_.accept('-') ||
          !text_.whole(UINT64_MAX, range.last) || range.last < range.first) {
        return fail("SG_MUL_VAL_ needs ranges such as 0-3, 7-7");
      }
      if (signal->range_count == DbcSignal::kMaxRanges) return fail("more than 4 multiplexer ranges");
      signal->ranges[signal->range_count++] = range;
    } while (text_.accept(','));
    return true;
  }

  // SIG_VALTYPE_ 100 Signal : 1;
  bool value_type() noexcept {
    DbcSignal* signal = nullptr;
    if (!known_signal(signal)) return false;
    if (signal == nullptr) return true;
    text_.accept(':');
    std::uint64_t type = 0;
    if (!text_.whole(3, type)) return fail("SIG_VALTYPE_ needs a type of 0..3");
    if (type == 1 && signal->length_bits == 32) {
      signal->number = DbcSignal::Number::kFloat32;
    } else if (type == 2 && signal->length_bits == 64) {
      signal->number = DbcSignal::Number::kFloat64;
    } else if (type != 0) {
      return fail("SIG_VALTYPE_ needs 32 bits for type 1, 64 for type 2");
    }
    return true;
  }

  // BA_ "VFrameFormat" BO_ 2365475321 3;
  bool attribute() noexcept {
    std::uint64_t id = 0;
    std::uint64_t format = 0;
    if (text_.quoted() != kFrameFormat || text_.word() != "BO_") return true;
    if (!text_.whole(UINT32_MAX, id) || !text_.whole(UINT32_MAX, format))
      return fail("VFrameFormat needs an id and a number");
    if (DbcMessage* message = find_id(id)) set_format(*message, format == kJ1939Format);
    return true;
  }

  // BA_DEF_DEF_ "VFrameFormat" "J1939PG"; comes before any BA_.
  bool attribute_default() noexcept {
    if (text_.quoted() != kFrameFormat) return true;
    const bool j1939 = text_.quoted() == "J1939PG";
    for (std::size_t i = 0; i < dbc_.message_count; ++i) set_format(dbc_.messages[i], j1939);
    return true;
  }

  static void set_format(DbcMessage& message, bool j1939) noexcept {
    message.parameter_group = j1939 && message.extended;
  }

  // "<id> <signal>"; nullptr if the message was not kept.
  bool known_signal(DbcSignal*& signal) noexcept {
    std::uint64_t id = 0;
    if (!text_.whole(UINT32_MAX, id)) return fail("an id of at most 32 bits is missing");
    const std::string_view name = text_.word();
    message_of_ = find_id(id);
    signal = nullptr;
    if (message_of_ == nullptr) return true;
    const DbcSignal* found = dbc_.find_signal(*message_of_, name);
    if (found == nullptr) return fail("the message has no such signal");
    signal = &dbc_.signals[found - dbc_.signals];
    return true;
  }

  [[nodiscard]] DbcMessage* find_id(std::uint64_t id) const noexcept {
    for (std::size_t i = 0; i < dbc_.message_count; ++i) {
      DbcMessage& m = dbc_.messages[i];
      if ((m.id | (m.extended ? kExtendedFlag : 0)) == id) return &m;
    }
    return nullptr;
  }

  // Without SG_MUL_VAL_, the multiplexed signals of a message hang on its first plain multiplexer.
  bool close_message() noexcept {
    if (open_ == nullptr) return true;
    const std::size_t end = dbc_.signal_count;
    std::int16_t root = -1;
    for (std::size_t i = end; i-- > open_->first_signal;) {
      if (dbc_.signals[i].is_multiplexer && dbc_.signals[i].range_count == 0)
        root = static_cast<std::int16_t>(i);
    }
    for (std::size_t i = open_->first_signal; i < end; ++i) {
      if (dbc_.signals[i].range_count == 0) continue;
      if (root < 0) return fail("the message before has multiplexed signals but no multiplexer");
      dbc_.signals[i].multiplexer = root;
    }
    open_ = nullptr;
    return true;
  }

  bool check_depth() noexcept {
    for (std::size_t i = 0; i < dbc_.signal_count; ++i) {
      int depth = 0;
      for (std::int16_t at = dbc_.signals[i].multiplexer; at >= 0; at = dbc_.signals[at].multiplexer) {
        if (++depth > Dbc::kMaxMultiplexers)
          return fail("multiplexers that hang on each other in a circle or beyond 8 levels");
      }
    }
    return true;
  }

  DbcText text_;
  std::span<const std::string_view> wanted_;
  Dbc& dbc_;
  std::int64_t statement_line_ = 1;
  const char* reason_ = "";
  bool in_message_ = false;
  DbcMessage* open_ = nullptr;              // the kept message whose SG_ lines are being read
  const DbcMessage* message_of_ = nullptr;  // that of the last known_signal()
};

}  // namespace

Status read_dbc(std::string_view text, std::span<const std::string_view> wanted, Dbc& dbc) noexcept {
  dbc.message_count = 0;
  dbc.signal_count = 0;
  const Status status = Reader(text, wanted, dbc).read();
  if (!status.ok()) {
    dbc.message_count = 0;
    dbc.signal_count = 0;
  }
  return status;
}

}  // namespace egofocus
