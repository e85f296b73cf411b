// Options of replay and eval that add errors to the measured motion.
#pragma once

#include <CLI/CLI.hpp>
#include <map>
#include <string>

#include "egofocus/config.hpp"

namespace egofocus::app {

/// `noise` must outlive the parsing.
inline void add_noise_options(CLI::App& command, VelocityNoise& noise) {
  command
      .add_option("--velocity-noise", noise.percent, "add errors of so many percent to the measured motion")
      ->check(CLI::Range(0.0, 1000.0));
  command.add_option("--seed", noise.seed, "of these errors")->capture_default_str();
  const std::map<std::string, NoiseKind> kinds{{"variance", NoiseKind::kVariance},
                                               {"std", NoiseKind::kDeviation}};
  command
      .add_option("--noise-kind", noise.kind,
                  "variance: sigma^2 = percent of the norm (default); std: sigma = percent of the norm")
      ->transform(CLI::CheckedTransformer(kinds).description(""));
  const std::map<std::string, NoiseDraw> draws{{"sample", NoiseDraw::kSample},
                                               {"window", NoiseDraw::kWindow}};
  command
      .add_option("--noise-per", noise.draw,
                  "sample: each of a window's 20 motion samples errs on its own (default); window: all alike")
      ->transform(CLI::CheckedTransformer(draws).description(""));
}

inline const char* kind_text(const VelocityNoise& noise) {
  return noise.kind == NoiseKind::kVariance ? "variance" : "std";
}
inline const char* draw_text(const VelocityNoise& noise) {
  return noise.draw == NoiseDraw::kSample ? "sample" : "window";
}

}  // namespace egofocus::app
