// Scores of the hypotheses -> index and confidence, in integers: docs/integer_model.md, "Regression" and
// "Confidence".
#pragma once

#include <cstdint>

namespace egofocus {

class Regression {
 public:
  /// RT: no (set-up).
  Regression() noexcept;

  /// A row of cells. The score of hypothesis k < used is head[x * hypotheses + k] + own[x * hypotheses + k],
  /// in 1/32; shift[x]: the context's byte of the displacement's norm. Index in 1/256 hypothesis. used >= 1.
  /// spread_q8: that of p about the index plus one pixel's worth, in the same unit; 65535 where it is more.
  /// Thread: any. RT: yes.
  void row(const std::int16_t* head, const std::int16_t* own, const std::uint8_t* shift, std::int32_t width,
           std::int32_t hypotheses, std::int32_t used, std::uint16_t* index_q8, std::uint8_t* confidence,
           std::uint16_t* spread_q8) const noexcept;

 private:
  static constexpr std::int32_t kEntries = 512;
  std::uint16_t exponential_[kEntries];  // round(65535 exp(-n / 32))
};

}  // namespace egofocus
