// One convolution of the network: a layer of the model with its weights packed for the kernel in use.
#pragma once

#include <cstdint>

#include "core/arena.hpp"
#include "kernels/kernel_table.hpp"
#include "pipeline/model.hpp"
#include "pipeline/tensor.hpp"

namespace egofocus {

class ConvLayer {
 public:
  ConvLayer() noexcept = default;
  /// Packs into the arena. `channels` of the input tensor: a multiple of 4, at least the layer's inputs for
  /// each of the `copies` (ConvWeights::copies).
  ConvLayer(const ModelLayer& layer, std::int32_t channels, const KernelTable& kernels, Arena& arena,
            std::int32_t copies = 1) noexcept;

  [[nodiscard]] std::int32_t outputs() const noexcept { return conv_.out_channels; }

  /// Rows first .. first + rows - 1 of the output. `input` has its border filled where the layer looks beyond
  /// the edge. Parts may run at once. RT: yes.
  void relu(const Tensor& input, const Tensor& output, std::int32_t first, std::int32_t rows) const noexcept;
  /// The same to pixels of another stride, such as some channels of a wider tensor.
  void relu(const Tensor& input, std::uint8_t* output, std::int32_t pixel_stride, std::int32_t row_stride,
            std::int32_t first, std::int32_t rows) const noexcept;
  /// Added to what `sum` holds.
  void add(const Tensor& input, const Tensor& sum, std::int32_t first, std::int32_t rows) const noexcept;
  /// s8, dense: [height][width][outputs].
  void small(const Tensor& input, std::int8_t* output, std::int32_t first, std::int32_t rows) const noexcept;
  /// s16: pixel (0, 0) of the output at `output`; strides in bytes.
  void scores(const Tensor& input, std::int16_t* output, std::int32_t pixel_stride, std::int32_t row_stride,
              std::int32_t first, std::int32_t rows) const noexcept;
  /// s16 of pixels without a border, [height][row_stride] bytes: dense, [height][width][outputs]. 1x1 alone.
  void scores(const std::uint8_t* input, std::int32_t row_stride, std::int32_t height, std::int32_t width,
              std::int16_t* output) const noexcept;

 private:
  [[nodiscard]] ConvU8S8 call(const Tensor& input, std::int32_t first, std::int32_t rows) const noexcept;

  ConvU8S8Function* run_ = nullptr;
  ConvU8S8 conv_;
};

}  // namespace egofocus
