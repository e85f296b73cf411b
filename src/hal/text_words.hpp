// Words of a line. Plain loops in place of string_view's find and substr, which call what the library may
// not.
#pragma once

#include <cstddef>
#include <string_view>

namespace egofocus {

/// Where `c` stands first, or text.size().
/// Thread: any. RT: yes.
inline std::size_t index_of(std::string_view text, char c) noexcept {
  std::size_t i = 0;
  while (i < text.size() && text[i] != c) ++i;
  return i;
}

/// The first `count` characters. Precondition: count <= text.size().
/// Thread: any. RT: yes.
inline std::string_view first_of(std::string_view text, std::size_t count) noexcept {
  return {text.data(), count};
}

/// Takes the first word off `text`, what stands between blanks (spaces, tabs, CR); empty at the end.
/// Thread: any. RT: yes.
inline std::string_view take_word(std::string_view& text) noexcept {
  const auto is_blank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  std::size_t length = 0;
  while (length < text.size() && !is_blank(text[length])) ++length;
  const std::string_view word = first_of(text, length);
  text.remove_prefix(length);
  return word;
}

}  // namespace egofocus
