#include <charconv>

#include "recording/aedat4_reader.hpp"

namespace egofocus::recording {
namespace {

/// The value of `key="..."` inside one tag; empty if it is not there.
std::string_view attribute(std::string_view tag, std::string_view key) {
  for (std::size_t at = tag.find(key); at != std::string_view::npos; at = tag.find(key, at + 1)) {
    const std::string_view rest = tag.substr(at + key.size());
    if (at > 0 && tag[at - 1] == ' ' && rest.starts_with("=\"")) {
      const std::string_view value = rest.substr(2);
      return value.substr(0, value.find('"'));
    }
  }
  return {};
}

std::int32_t whole_number(std::string_view text) {
  std::int32_t value = -1;
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), value);
  return problem == std::errc() && end == text.data() + text.size() ? value : -1;
}

}  // namespace

// The tree is <node name="outInfo"><node name="ID"> attributes <node name="info"> attributes: a stream is a
// node two levels down, and belongs to it what stands before the node is closed.
std::vector<Aedat4Stream> parse_info_node(std::string_view xml) {
  std::vector<Aedat4Stream> streams;
  int depth = 0;
  while (!xml.empty()) {
    const std::size_t open = xml.find('<');
    const std::size_t close = xml.find('>', open == std::string_view::npos ? 0 : open);
    if (open == std::string_view::npos || close == std::string_view::npos) break;
    const std::string_view tag = xml.substr(open + 1, close - open - 1);
    xml.remove_prefix(close + 1);
    const std::string_view content = xml.substr(0, xml.find('<'));
    if (tag.starts_with("node ") && !tag.ends_with("/")) {
      ++depth;
      const std::int32_t id = whole_number(attribute(tag, "name"));
      if (depth == 2) streams.push_back({id, "", 0, 0});
    } else if (tag == "/node") {
      --depth;
    } else if (tag.starts_with("attr ") && depth >= 2 && !streams.empty()) {
      const std::string_view key = attribute(tag, "key");
      if (key == "typeIdentifier") streams.back().type = content;
      if (key == "sizeX") streams.back().width_px = whole_number(content);
      if (key == "sizeY") streams.back().height_px = whole_number(content);
    }
  }
  std::erase_if(streams, [](const Aedat4Stream& stream) { return stream.id < 0 || stream.type.empty(); });
  return streams;
}

}  // namespace egofocus::recording
