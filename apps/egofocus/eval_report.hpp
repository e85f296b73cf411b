// Tables for people and JSON for programs of what an evaluation found.
#pragma once

#include <string>
#include <vector>

#include "egofocus/config.hpp"
#include "recording/evaluation.hpp"
#include "recording/json.hpp"

namespace egofocus::app {

using recording::Json;

enum class Mask { kBoth, kAll, kEvents };

/// All methods of one recording, or of all: a table per pixel set, and the confidence's curve.
[[nodiscard]] std::string eval_text(const recording::SequenceScore& score, Mask mask);

/// The same with every number; `images` adds one entry per image.
[[nodiscard]] Json eval_json(const recording::SequenceScore& score, bool images);

/// One row of the noise study.
struct NoiseRow {
  VelocityNoise noise;
  recording::SequenceScore score;
};

/// A table per method, one row per percentage, over the pixels where every compared method has an estimate.
[[nodiscard]] std::string noise_text(const std::vector<NoiseRow>& rows, Mask mask);
[[nodiscard]] Json noise_json(const std::vector<NoiseRow>& rows);

}  // namespace egofocus::app
