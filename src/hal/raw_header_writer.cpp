#include <string_view>

#include "hal/raw_header.hpp"

namespace egofocus {
namespace {

// Appends while there is room, and knows when there was not.
class Text {
 public:
  explicit Text(std::span<std::byte> out) noexcept : out_(out) {}
  Text& add(std::string_view text) noexcept {
    for (const char c : text) put(c);
    return *this;
  }
  Text& add(std::uint32_t number) noexcept {
    if (number >= 10) add(number / 10);
    put(static_cast<char>('0' + number % 10));
    return *this;
  }
  // "% key value": a value that would break the line ends before it does.
  void line(std::string_view key, std::span<const char> value) noexcept {
    if (value[0] == '\0') return;
    add("% ").add(key).add(" ");
    for (std::size_t i = 0; i < value.size() && value[i] != '\0' && value[i] != '\n'; ++i) put(value[i]);
    add("\n");
  }
  [[nodiscard]] std::size_t size() const noexcept { return size_ <= out_.size() ? size_ : 0; }

 private:
  void put(char c) noexcept {
    if (size_ < out_.size()) out_[size_] = static_cast<std::byte>(c);
    ++size_;
  }

  std::span<std::byte> out_;
  std::size_t size_ = 0;
};

struct Names {
  std::string_view format;
  std::string_view evt;
  std::string_view endianness;
};

Names names_of(EvtFormat format) noexcept {
  switch (format) {
    case EvtFormat::kEvt2:
      return {"EVT2", "2.0", "little"};
    case EvtFormat::kEvt21:
      return {"EVT21", "2.1", "little"};
    case EvtFormat::kEvt21Legacy:
      return {"EVT21", "2.1", "legacy"};
    case EvtFormat::kEvt3:
      return {"EVT3", "3.0", "little"};
  }
  return {};
}

}  // namespace

std::size_t write_raw_header(const RawHeader& header, std::span<std::byte> out) noexcept {
  const Names names = names_of(header.format);
  const std::uint32_t width = header.size.width_px;
  const std::uint32_t height = header.size.height_px;
  Text text(out);
  text.line("date", header.date);
  text.add("% endianness ").add(names.endianness).add("\n");
  text.add("% evt ").add(names.evt).add("\n");
  text.add("% format ").add(names.format).add(";height=").add(height).add(";width=").add(width);
  if (header.format == EvtFormat::kEvt21Legacy) text.add(";endianness=legacy");
  text.add("\n% geometry ").add(width).add("x").add(height).add("\n");
  text.line("sensor_name", header.sensor_name);
  text.line("serial_number", header.serial_number);
  text.add("% end\n");
  return text.size();
}

}  // namespace egofocus
