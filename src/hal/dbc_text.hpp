// The characters of a DBC file as words, numbers and marks; counts lines. Encoding does not matter: bytes
// above 127 stand in quotes only.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "core/decimal.hpp"

namespace egofocus {

/// All but skip_line() stay on their line.
/// Thread: one at a time. RT: no heap, no locale; for set-up.
class DbcText {
 public:
  explicit DbcText(std::string_view text) noexcept : text_(text) {}

  [[nodiscard]] bool at_end() const noexcept { return at_ == text_.size(); }
  [[nodiscard]] std::int64_t line() const noexcept { return line_; }  ///< from 1

  /// Nothing but blanks is left of the line.
  bool at_line_end() noexcept {
    skip_blanks();
    return at_end() || text_[at_] == '\n';
  }

  /// Takes `c` if it comes next.
  bool accept(char c) noexcept {
    skip_blanks();
    if (at_end() || text_[at_] != c) return false;
    ++at_;
    return true;
  }

  /// A C identifier or a keyword; empty if something else comes next.
  std::string_view word() noexcept { return take(is_name_char); }

  /// What stands in quotes on this line, without them; empty if something else comes next, or no quote closes
  /// it.
  std::string_view quoted() noexcept {
    skip_blanks();
    const std::size_t end = at_end() || text_[at_] != '"' ? text_.npos : text_.find_first_of("\"\n", at_ + 1);
    if (end == text_.npos || text_[end] != '"') return {};
    const std::string_view inside(text_.data() + at_ + 1, end - at_ - 1);
    at_ = end + 1;
    return inside;
  }

  bool real(double& value) noexcept {
    const std::string_view digits = take(is_number_char);
    Decimal number;
    return !digits.empty() && scan_decimal(digits, number) == digits.size() && to_double(number, value);
  }

  /// A whole number of 0..max.
  bool whole(std::uint64_t max, std::uint64_t& value) noexcept {
    return whole_in(take(is_digit), max, value);
  }

  static bool whole_in(std::string_view digits, std::uint64_t max, std::uint64_t& value) noexcept {
    value = 0;
    for (const char c : digits) {
      if (!is_digit(c)) return false;
      const auto digit = static_cast<std::uint64_t>(c - '0');
      if (digit > max || value > (max - digit) / 10) return false;
      value = value * 10 + digit;
    }
    return !digits.empty();
  }

  /// To the start of the next line; line ends in quotes do not count, and \" does not end a quote. False if
  /// the text ends in quotes.
  bool skip_line() noexcept {
    bool quoted = false;
    for (; at_ < text_.size(); ++at_) {
      const char c = text_[at_];
      if (c == '\n') ++line_;
      if (c == '\n' && !quoted) {
        ++at_;
        return true;
      }
      if (c == '"') quoted = !quoted;
      if (c == '\\' && quoted && at_ + 1 < text_.size() && text_[at_ + 1] == '"') ++at_;
    }
    return !quoted;
  }

 private:
  static bool is_digit(char c) noexcept { return c >= '0' && c <= '9'; }
  static bool is_name_char(char c) noexcept {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || is_digit(c) || c == '_';
  }
  static bool is_number_char(char c) noexcept {
    return is_digit(c) || c == '.' || c == '+' || c == '-' || c == 'e' || c == 'E';
  }

  void skip_blanks() noexcept {
    while (!at_end() && (text_[at_] == ' ' || text_[at_] == '\t' || text_[at_] == '\r')) ++at_;
  }

  template <typename Belongs>
  std::string_view take(Belongs belongs) noexcept {
    skip_blanks();
    const std::size_t first = at_;
    while (!at_end() && belongs(text_[at_])) ++at_;
    return {text_.data() + first, at_ - first};
  }

  std::string_view text_;
  std::size_t at_ = 0;
  std::int64_t line_ = 1;
};

}  // namespace egofocus
