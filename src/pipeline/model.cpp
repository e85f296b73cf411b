#include "pipeline/model.hpp"

#include <bit>
#include <cstring>

#include "pipeline/hypothesis_ladder.hpp"
#include "pipeline/model_bytes.hpp"

namespace egofocus {
namespace {

// Biases, scales and weights are used where they lie.
static_assert(std::endian::native == std::endian::little);

constexpr char kMagic[8] = {'\x89', 'E', 'F', 'M', '\r', '\n', '\x1a', '\n'};
constexpr std::size_t kVersionAt = 8;
constexpr std::size_t kTotalAt = 12;
constexpr std::size_t kCrcAt = 16;
constexpr std::size_t kSectionCountAt = 20;
constexpr std::size_t kSectionsAt = 32;
constexpr std::size_t kSectionBytes = 16;
constexpr std::uint32_t kMostSections = 64;
constexpr std::size_t kLayerBytes = 48;
constexpr std::size_t kFactsBytes = 128;
constexpr std::size_t kMostCardBytes = 65536;
constexpr std::uint32_t kConvolution = 1;
constexpr std::int32_t kMedian = 1;
constexpr std::int32_t kMostBias = 1 << 30;
constexpr float kLeastScale = 0x1p-40f;

enum Section : std::uint32_t { kFacts = 1, kCard, kLayers, kData };

struct Sections {
  struct Piece {
    std::size_t at = 0;
    std::size_t bytes = 0;
    bool found = false;
  } of[kData + 1];
};

Status bad(const char* what, std::size_t at, std::int64_t value = 0) noexcept {
  return {StatusCode::kBadModel, what, static_cast<std::int64_t>(at), value};
}

// `bytes` shrink to the model itself.
Status read_header(std::span<const std::byte>& bytes) noexcept {
  if (bytes.size() < kSectionsAt) return bad("shorter than a header", bytes.size());
  if (std::memcmp(bytes.data(), kMagic, sizeof kMagic) != 0) return bad("no model file", 0);
  if (reinterpret_cast<std::uintptr_t>(bytes.data()) % Model::kAlignment != 0)
    return bad("its memory does not begin at a multiple of 16", 0);
  const std::uint32_t version = read_u32(bytes, kVersionAt);
  if (version != Model::kVersion) return {StatusCode::kUnsupportedModel, "version", version, Model::kVersion};
  const std::uint32_t total = read_u32(bytes, kTotalAt);
  if (total < kSectionsAt || total > bytes.size()) return bad("cut short", bytes.size(), total);
  bytes = bytes.first(total);
  const std::uint32_t crc = crc32(bytes.subspan(kCrcAt + 4));
  if (crc != read_u32(bytes, kCrcAt)) return bad("damaged (check sum)", kCrcAt, crc);
  return {};
}

Status read_sections(std::span<const std::byte> bytes, Sections& out) noexcept {
  const std::uint32_t count = read_u32(bytes, kSectionCountAt);
  if (count > kMostSections || kSectionsAt + count * kSectionBytes > bytes.size())
    return bad("number of sections", kSectionCountAt, count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t entry = kSectionsAt + i * kSectionBytes;
    const std::uint32_t kind = read_u32(bytes, entry);
    const std::size_t at = read_u32(bytes, entry + 8);
    const std::size_t size = read_u32(bytes, entry + 12);
    if (at % Model::kAlignment != 0 || at > bytes.size() || size > bytes.size() - at)
      return bad("section outside the file, or not at a multiple of 16", entry,
                 static_cast<std::int64_t>(at));
    if (kind < kFacts || kind > kData) continue;  // of a later writer, who did not need us to know it
    Sections::Piece& piece = out.of[kind];
    if (piece.found) return bad("section of a kind that came before", entry, kind);
    piece = {at, size, true};
  }
  for (const std::uint32_t kind : {kFacts, kCard, kLayers, kData}) {
    if (!out.of[kind].found) return bad("section missing", kSectionCountAt, kind);
  }
  return {};
}

class FactsReader {
 public:
  FactsReader(std::span<const std::byte> bytes, std::size_t at) noexcept : bytes_(bytes), at_(at) {}

  // A whole number within low..high that `step` divides.
  std::int32_t number(const char* name, std::uint32_t low, std::uint32_t high,
                      std::uint32_t step = 1) noexcept {
    return checked(name, read_u32(bytes_, at_ + used_), 4, low, high, step);
  }
  std::int32_t byte(const char* name, std::uint32_t low, std::uint32_t high) noexcept {
    return checked(name, static_cast<std::uint32_t>(bytes_[at_ + used_]), 1, low, high, 1);
  }
  double real() noexcept {
    used_ += 8;
    return read_f64(bytes_, at_ + used_ - 8);
  }
  void skip(std::size_t bytes) noexcept { used_ += bytes; }
  [[nodiscard]] const Status& status() const noexcept { return status_; }

 private:
  std::int32_t checked(const char* name, std::uint32_t value, std::size_t bytes, std::uint32_t low,
                       std::uint32_t high, std::uint32_t step) noexcept {
    const bool fits = value >= low && value <= high && value % step == 0;
    if (!fits && status_.ok()) status_ = bad(name, at_ + used_, value);
    used_ += bytes;
    return static_cast<std::int32_t>(fits ? value : low);
  }

  std::span<const std::byte> bytes_;
  std::size_t at_;
  std::size_t used_ = 0;
  Status status_;
};

Status read_facts(std::span<const std::byte> bytes, const Sections::Piece& piece, ModelFacts& out) noexcept {
  if (piece.bytes != kFactsBytes)
    return bad("size of the facts", piece.at, static_cast<std::int64_t>(piece.bytes));
  FactsReader in(bytes, piece.at);
  out = {};
  out.ladder.span_px = in.real();
  out.ladder.min_parallax_px = in.real();
  out.ladder.kind = static_cast<LadderKind>(in.number("ladder kind", 0, 1));
  out.ladder.hypotheses = in.number("hypotheses", 8, 64, 8);
  out.max_events = in.number("max_events", 100, 1'000'000);
  out.input.floor_events_milli = in.number("floor_events", 20, 2000);
  out.input.floor_noise_milli = in.number("floor_noise", 100, 8000);
  out.input.map_count = in.number("number of maps", 1, FocusInputConfig::kMostMaps);
  for (std::int32_t m = 0; m < FocusInputConfig::kMostMaps; ++m) {
    const bool used = m < out.input.map_count;
    out.input.maps[m].kind = static_cast<FocusMapKind>(in.byte("map", 0, used ? 3 : 0));
    const std::int32_t side = in.byte("side of a map's support", used ? 1 : 0, used ? 7 : 0);
    if (used) out.input.maps[m].side = side;
  }
  out.grid_width_px = in.number("grid width", 0, 1280);
  out.grid_height_px = in.number("grid height", 0, 1280);
  out.focus_layers = in.number("convolutions per hypothesis", 1, 2);
  out.cost_channels = in.number("channels per hypothesis", 2, 16, 2);
  for (std::int32_t& width : out.widths) width = in.number("width", 4, 512, 4);
  for (std::int32_t& blocks : out.blocks) blocks = in.number("blocks", 0, 8);
  for (std::int32_t& blocks : out.up_blocks) blocks = in.number("blocks on the way up", 0, 8);
  out.refine_width = in.number("width of the refinement", 4, 64, 4);
  const std::int32_t regression = in.number("regression", 0, 255);
  out.dilation_count = in.number("convolutions of the refinement", 0, ModelFacts::kMostDilations);
  for (std::int32_t i = 0; i < ModelFacts::kMostDilations; ++i) {
    const bool used = i < out.dilation_count;
    out.dilations[i] = in.byte("dilation", used ? 1 : 0, used ? 4 : 0);
  }
  const bool hidden = out.focus_layers == 2;
  out.cost_hidden = in.number("channels between the focus convolutions", hidden ? 4 : 0, hidden ? 64 : 0, 4);
  if (!in.status().ok()) return in.status();
  if (regression != kMedian) return {StatusCode::kUnsupportedModel, "regression", regression, kMedian};
  if (const Status status = check_ladder(out.ladder); !status.ok()) return bad(status.subject(), piece.at);
  if (const Status status = FocusInput::check(out.input); !status.ok())
    return bad(status.subject(), piece.at, status.value());
  if ((out.grid_width_px == 0) != (out.grid_height_px == 0)) return bad("grid", piece.at, out.grid_width_px);
  return {};
}

Status read_card(std::span<const std::byte> bytes, const Sections::Piece& piece,
                 std::string_view& out) noexcept {
  if (piece.bytes > kMostCardBytes)
    return bad("card too long", piece.at, static_cast<std::int64_t>(piece.bytes));
  out = {reinterpret_cast<const char*>(bytes.data()) + piece.at, piece.bytes};
  for (std::size_t i = 0; i < out.size(); ++i) {
    const auto c = static_cast<unsigned char>(out[i]);
    if ((c < 0x20 && c != '\n') || c == 0x7f) return bad("card: control character", piece.at + i, c);
  }
  return {};
}

// Where `size` bytes at a layer's offset lie, or nullptr when not inside the data.
const std::byte* data_at(std::span<const std::byte> bytes, const Sections::Piece& data, std::size_t offset,
                         std::size_t size) noexcept {
  const bool inside = offset % Model::kAlignment == 0 && offset >= data.at &&
                      offset <= data.at + data.bytes && size <= data.at + data.bytes - offset;
  return inside ? bytes.data() + offset : nullptr;
}

Status read_layer(std::span<const std::byte> bytes, const Sections::Piece& data, std::size_t entry,
                  ModelLayer& layer) noexcept {
  const auto field = [&](std::size_t n) noexcept { return read_u32(bytes, entry + 4 * n); };
  if (field(0) != kConvolution) return {StatusCode::kUnsupportedModel, "operator", field(0), kConvolution};
  const std::uint32_t expected[] = {
      static_cast<std::uint32_t>(layer.shape.outputs),  static_cast<std::uint32_t>(layer.shape.inputs),
      static_cast<std::uint32_t>(layer.shape.side),     static_cast<std::uint32_t>(layer.shape.stride),
      static_cast<std::uint32_t>(layer.shape.dilation), static_cast<std::uint32_t>(layer.shape.zero)};
  for (std::size_t i = 0; i < std::size(expected); ++i) {
    if (field(1 + i) != expected[i])
      return bad("layer of another shape than the facts say", entry + 4 * (1 + i), field(1 + i));
  }
  const auto outputs = static_cast<std::size_t>(layer.shape.outputs);
  const std::size_t weights = outputs * static_cast<std::size_t>(layer.shape.inputs) *
                              static_cast<std::size_t>(layer.shape.side * layer.shape.side);
  const std::byte* const at[] = {data_at(bytes, data, field(7), weights),
                                 data_at(bytes, data, field(8), 4 * outputs),
                                 data_at(bytes, data, field(9), 4 * outputs)};
  for (std::size_t i = 0; i < std::size(at); ++i) {
    if (at[i] == nullptr)
      return bad("weights outside the data, or not at a multiple of 16", entry + 4 * (7 + i), field(7 + i));
  }
  layer.weights = reinterpret_cast<const std::int8_t*>(at[0]);
  layer.bias = reinterpret_cast<const std::int32_t*>(at[1]);
  layer.scale = reinterpret_cast<const float*>(at[2]);
  for (std::size_t i = 0; i < weights; ++i) {
    if (layer.weights[i] == -128) return bad("weight -128", field(7) + i, -128);
  }
  for (std::size_t i = 0; i < outputs; ++i) {
    if (layer.bias[i] < -kMostBias || layer.bias[i] > kMostBias)
      return bad("bias beyond 2^30", field(8) + 4 * i, layer.bias[i]);
    if (!(layer.scale[i] >= kLeastScale && layer.scale[i] < 1.0f))
      return bad("scale outside 2^-40 to 1", field(9) + 4 * i);
  }
  return {};
}

}  // namespace

const char* to_string(LayerRole role) noexcept {
  constexpr const char* kNames[kLayerRoles] = {
      "focus cost", "mix",         "at 1/4",    "down to 1/8", "at 1/8",    "down to 1/16",
      "at 1/16",    "narrow 1/16", "up at 1/8", "narrow 1/8",  "up at 1/4", "head",
      "own",        "guide",       "first",     "body",        "last"};
  return kNames[static_cast<std::size_t>(role)];
}

std::int32_t layer_shapes(const ModelFacts& facts, std::span<ModelLayer> out) noexcept {
  std::int32_t count = 0;
  const auto add = [&](LayerRole role, std::int32_t inputs, std::int32_t outputs, std::int32_t side,
                       std::int32_t stride = 1, std::int32_t dilation = 1, std::int32_t zero = 0) noexcept {
    ModelLayer& layer = out[static_cast<std::size_t>(count++)];
    layer.role = role;
    layer.shape = {outputs, inputs, side, stride, dilation, zero};
  };
  const auto blocks = [&](LayerRole role, std::int32_t n, std::int32_t width) noexcept {
    for (std::int32_t i = 0; i < 2 * n; ++i) add(role, width, width, 3);
  };
  const auto [w4, w8, w16] = facts.widths;
  std::int32_t inputs = facts.input.map_count;
  if (facts.focus_layers == 2) {
    add(LayerRole::kFocusCost, inputs, facts.cost_hidden, 3, 1, 1, kInputZero);
    inputs = facts.cost_hidden;
  }
  add(LayerRole::kFocusCost, inputs, facts.cost_channels, 3, 1, 1, facts.focus_layers == 2 ? 0 : kInputZero);
  const std::int32_t context = facts.input.map_count + 6;
  add(LayerRole::kMix, facts.ladder.hypotheses * facts.cost_channels + context, w4, 1);
  blocks(LayerRole::kAt4, facts.blocks[0], w4);
  add(LayerRole::kDown8, w4, w8, 3, 2);
  blocks(LayerRole::kAt8, facts.blocks[1], w8);
  add(LayerRole::kDown16, w8, w16, 3, 2);
  blocks(LayerRole::kAt16, facts.blocks[2], w16);
  add(LayerRole::kNarrow16, w16, w8, 1);
  blocks(LayerRole::kUp8, facts.up_blocks[1], w8);
  add(LayerRole::kNarrow8, w8, w4, 1);
  blocks(LayerRole::kUp4, facts.up_blocks[0], w4);
  add(LayerRole::kHead, w4, facts.ladder.hypotheses, 1);
  add(LayerRole::kOwn, facts.cost_channels, 1, 1);
  add(LayerRole::kGuide, w4, 4, 1);
  add(LayerRole::kFirst, 8, facts.refine_width, 3);
  for (std::int32_t i = 0; i < facts.dilation_count; ++i)
    add(LayerRole::kBody, facts.refine_width, facts.refine_width, 3, 1, facts.dilations[i]);
  add(LayerRole::kLast, facts.refine_width, 1, 3);
  return count;
}

Status read_model(std::span<const std::byte> bytes, Model& out) noexcept {
  out = {};
  if (const Status status = read_header(bytes); !status.ok()) return status;
  Sections sections;
  if (const Status status = read_sections(bytes, sections); !status.ok()) return status;
  if (const Status status = read_facts(bytes, sections.of[kFacts], out.facts); !status.ok()) return status;
  if (const Status status = read_card(bytes, sections.of[kCard], out.card); !status.ok()) return status;
  out.layer_count = layer_shapes(out.facts, out.layers);
  const Sections::Piece& table = sections.of[kLayers];
  if (table.bytes != static_cast<std::size_t>(out.layer_count) * kLayerBytes)
    return bad("number of layers", table.at, static_cast<std::int64_t>(table.bytes / kLayerBytes));
  for (std::int32_t i = out.layer_count - 1; i >= 0; --i) {
    ModelLayer& layer = out.layers[i];
    out.first_layer[static_cast<std::size_t>(layer.role)] = i;
    const std::size_t entry = table.at + static_cast<std::size_t>(i) * kLayerBytes;
    if (const Status status = read_layer(bytes, sections.of[kData], entry, layer); !status.ok())
      return status;
  }
  return {};
}

}  // namespace egofocus
