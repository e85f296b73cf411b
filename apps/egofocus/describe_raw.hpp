// Facts about event streams.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "egofocus/types.hpp"
#include "recording/json.hpp"

namespace egofocus::app {

using recording::Json;

/// Counts, times, mean rate, and the most events in any 10 ms as a rate.
void add_event_facts(std::span<const Event> events, Json& facts);

/// Decodes the whole file. Throws recording::Error (kBadFile) when the header is none.
Json describe_raw(std::span<const std::byte> file, const std::string& name);

}  // namespace egofocus::app
