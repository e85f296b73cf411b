// Model files: whatever the bytes, an answer; and what is accepted can be read to its last weight.
#include <memory>
#include <new>

#include "fuzz/fuzz_input.hpp"
#include "pipeline/model.hpp"
#include "pipeline/model_bytes.hpp"

using namespace egofocus;

namespace {

// Exactly as long as the input, at a multiple of 16: a look beyond is seen.
class Copy {
 public:
  Copy(const std::uint8_t* data, std::size_t size)
      : bytes_(static_cast<std::uint8_t*>(::operator new (size, std::align_val_t{16}))), size_(size) {
    for (std::size_t i = 0; i < size; ++i) bytes_[i] = data[i];
  }
  ~Copy() { ::operator delete (bytes_, std::align_val_t{16}); }
  Copy(const Copy&) = delete;
  Copy& operator=(const Copy&) = delete;

  // Most inputs would end at the check sum: it is made to agree.
  void seal() {
    if (size_ < 20) return;
    std::size_t total = 0;
    for (std::size_t i = 0; i < 4; ++i) total |= std::size_t{bytes_[12 + i]} << (8 * i);
    if (total < 20 || total > size_) total = size_;
    const std::uint32_t crc = crc32(bytes().subspan(20, total - 20));
    for (std::size_t i = 0; i < 4; ++i) bytes_[16 + i] = static_cast<std::uint8_t>(crc >> (8 * i));
  }
  [[nodiscard]] std::span<const std::byte> bytes() const { return std::as_bytes(std::span(bytes_, size_)); }

 private:
  std::uint8_t* bytes_;
  std::size_t size_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  Copy copy(data, size);
  copy.seal();
  static Model model;
  const Status status = read_model(copy.bytes(), model);
  if (!status.ok()) {
    fuzz::require(status.code() == StatusCode::kBadModel || status.code() == StatusCode::kUnsupportedModel);
    return 0;
  }
  fuzz::require(model.layer_count > 0 && model.layer_count <= Model::kMostLayers);
  std::int64_t sum = 0;
  for (std::int32_t i = 0; i < model.layer_count; ++i) {
    const ModelLayer& layer = model.layers[i];
    const LayerShape& s = layer.shape;
    const std::int32_t weights = s.outputs * s.inputs * s.side * s.side;
    for (std::int32_t w = 0; w < weights; ++w) sum += layer.weights[w];
    for (std::int32_t o = 0; o < s.outputs; ++o) {
      sum += layer.bias[o];
      fuzz::require(layer.scale[o] >= 0x1p-40f && layer.scale[o] < 1.0f);
    }
  }
  for (const char c : model.card) sum += c;
  fuzz::require(sum != INT64_MIN);
  return 0;
}
