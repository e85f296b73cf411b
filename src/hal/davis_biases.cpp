#include "hal/davis_biases.hpp"

#include <string_view>

#include "hal/inivation_port.hpp"

namespace egofocus {
namespace {

enum class Kind : std::uint8_t { kN, kP, kNCascode, kOff, kVoltage, kShiftedSource };

// kN, kP, kNCascode, kOff (an N bias that is disabled): coarse and fine. kVoltage: voltage and current.
// kShiftedSource: reference and regulator.
struct Row {
  std::uint16_t parameter;
  std::string_view name;
  Kind kind;
  std::uint32_t first;
  std::uint32_t second;
};

constexpr Row kDavis240[] = {
    {0, "DiffBn", Kind::kN, 4, 39},
    {1, "OnBn", Kind::kN, 5, 255},
    {2, "OffBn", Kind::kN, 4, 0},
    {3, "ApsCasEpc", Kind::kNCascode, 5, 185},
    {4, "DiffCasBnc", Kind::kNCascode, 5, 115},
    {5, "ApsROSFBn", Kind::kN, 6, 219},
    {6, "LocalBufBn", Kind::kN, 5, 164},
    {7, "PixInvBn", Kind::kN, 6, 144},
    {8, "PrBp", Kind::kP, 2, 58},
    {9, "PrSFBp", Kind::kP, 1, 16},
    {10, "RefrBp", Kind::kP, 4, 25},
    {11, "AEPdBn", Kind::kN, 6, 91},
    {12, "LcolTimeoutBn", Kind::kN, 5, 49},
    {13, "AEPuXBp", Kind::kP, 4, 80},
    {14, "AEPuYBp", Kind::kP, 7, 152},
    {15, "IFThrBn", Kind::kN, 5, 255},
    {16, "IFRefrBn", Kind::kN, 5, 255},
    {17, "PadFollBn", Kind::kN, 7, 215},
    {18, "ApsOverflowLevelBn", Kind::kN, 6, 253},
    {19, "BiasBuffer", Kind::kN, 5, 254},
    {20, "SSP", Kind::kShiftedSource, 1, 33},
    {21, "SSN", Kind::kShiftedSource, 1, 33},
};

constexpr Row kDavis346[] = {
    {0, "ApsOverflowLevel", Kind::kVoltage, 27, 6},
    {1, "ApsCas", Kind::kVoltage, 21, 6},
    {2, "AdcRefHigh", Kind::kVoltage, 32, 7},
    {3, "AdcRefLow", Kind::kVoltage, 1, 7},
    {4, "AdcTestVoltage", Kind::kVoltage, 21, 7},
    {8, "LocalBufBn", Kind::kN, 5, 164},
    {9, "PadFollBn", Kind::kOff, 7, 215},
    {10, "DiffBn", Kind::kN, 4, 39},
    {11, "OnBn", Kind::kN, 5, 255},
    {12, "OffBn", Kind::kN, 4, 1},
    {13, "PixInvBn", Kind::kN, 6, 144},
    {14, "PrBp", Kind::kP, 2, 58},
    {15, "PrSFBp", Kind::kP, 1, 16},
    {16, "RefrBp", Kind::kP, 4, 25},
    {17, "ReadoutBufBp", Kind::kP, 6, 20},
    {18, "ApsROSFBn", Kind::kN, 6, 219},
    {19, "AdcCompBp", Kind::kP, 5, 20},
    {20, "ColSelLowBn", Kind::kN, 0, 1},
    {21, "DACBufBp", Kind::kP, 6, 60},
    {22, "LcolTimeoutBn", Kind::kN, 5, 49},
    {23, "AEPdBn", Kind::kN, 6, 91},
    {24, "AEPuXBp", Kind::kP, 4, 80},
    {25, "AEPuYBp", Kind::kP, 7, 152},
    {26, "IFRefrBn", Kind::kN, 5, 255},
    {27, "IFThrBn", Kind::kN, 5, 255},
    {34, "BiasBuffer", Kind::kN, 5, 254},
    {35, "SSP", Kind::kShiftedSource, 1, 33},
    {36, "SSN", Kind::kShiftedSource, 1, 33},
};

bool has_codes(Kind kind) noexcept {
  return kind == Kind::kN || kind == Kind::kP || kind == Kind::kNCascode || kind == Kind::kOff;
}

// Coarse-fine: bit 0 on, 1 N type, 2 no cascode, 3 normal current level, 11..4 fine, 14..12 coarse. Voltage:
// 5..0 voltage, 8..6 current. Shifted source: 9..4 reference, 15..10 regulator, the bits below 0 for the mode
// of that name with a split gate.
std::uint32_t encoded(const Row& row) noexcept {
  if (row.kind == Kind::kVoltage) return row.first | row.second << 6;
  if (row.kind == Kind::kShiftedSource) return row.first << 4 | row.second << 10;
  const std::uint32_t on = row.kind == Kind::kOff ? 0 : 1;
  const std::uint32_t n_type = row.kind == Kind::kP ? 0 : 1;
  const std::uint32_t no_cascode = row.kind == Kind::kNCascode ? 0 : 1;
  return on | n_type << 1 | no_cascode << 2 | 1u << 3 | row.second << 4 | row.first << 12;
}

std::span<const Row> rows_of(bool is_346) noexcept {
  return is_346 ? std::span<const Row>(kDavis346) : std::span<const Row>(kDavis240);
}

Status check(const UsbBias& bias, std::span<const Row> rows, std::int64_t index) noexcept {
  for (const Row& row : rows) {
    if (row.name != bias.name) continue;
    if (!has_codes(row.kind))
      return {StatusCode::kBadDeviceSetting, "a bias that serves frames alone, counted from 0", index};
    if (bias.coarse < 0 || bias.coarse > 7)
      return {StatusCode::kBadDeviceSetting, "coarse code of a bias, 0..7", bias.coarse};
    if (bias.fine < 0 || bias.fine > 255)
      return {StatusCode::kBadDeviceSetting, "fine code of a bias, 0..255", bias.fine};
    return {};
  }
  return {StatusCode::kBadDeviceSetting, "a bias name that this DAVIS does not have, counted from 0", index};
}

}  // namespace

Status add_davis_biases(bool is_346, const UsbCameraSettings& settings, UsbSteps& steps) noexcept {
  const std::span<const Row> rows = rows_of(is_346);
  const std::span<const UsbBias> asked(settings.biases, settings.bias_count);
  for (std::size_t i = 0; i < asked.size(); ++i) {
    if (Status status = check(asked[i], rows, static_cast<std::int64_t>(i)); !status.ok()) return status;
  }
  for (Row row : rows) {
    for (const UsbBias& bias : asked) {
      if (row.name != bias.name) continue;
      row.first = static_cast<std::uint32_t>(bias.coarse);
      row.second = static_cast<std::uint32_t>(bias.fine);
    }
    steps.write(inivation_address(kBias, row.parameter), encoded(row));
  }
  return {};
}

}  // namespace egofocus
