// `citysim realism`: the statistics of event streams side by side, real and simulated.
#pragma once

#include <span>
#include <string>

namespace egofocus::citysim {

/// RECORDING... [--seconds S] [--json]. A recording is a folder with events.raw, a Prophesee RAW file, or
/// text events (t x y p). Prints one table, a column for each recording, or one line of JSON for each.
/// Returns an exit code of docs/formats.md; throws recording::Error.
int run_realism(std::span<const std::string> arguments);

}  // namespace egofocus::citysim
