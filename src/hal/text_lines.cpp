#include "hal/text_lines.hpp"

#include "hal/text_words.hpp"

namespace egofocus {

TextLines::Cut TextLines::next(std::span<const std::byte> bytes, bool last) noexcept {
  if (bytes.empty()) return {};
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const std::size_t length = index_of(text, '\n');
  const bool ended = length < text.size();
  const std::size_t consumed = length + (ended ? 1 : 0);

  if (skipping_) {
    skipping_ = !ended && !last;
    return {Kind::kSkipped, consumed, {}};
  }
  if (length > kMaxLineBytes) {
    skipping_ = !ended && !last;
    return {Kind::kOverLong, consumed, {}};
  }
  if (!ended && !last) return {};
  std::string_view line = first_of(text, length);
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  return {Kind::kLine, consumed, line};
}

}  // namespace egofocus
