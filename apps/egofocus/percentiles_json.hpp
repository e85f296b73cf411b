// Percentiles of times, as facts.
#pragma once

#include "recording/json.hpp"
#include "recording/tick_times.hpp"

namespace egofocus::app {

inline recording::Json percentiles_json(const recording::Percentiles& of) {
  return recording::Json().add("p50", of.p50).add("p99", of.p99).add("max", of.max);
}

}  // namespace egofocus::app
