// Facts of a model file.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "recording/json.hpp"

namespace egofocus::app {

using recording::Json;

/// Throws recording::Error (kBadFile) when the bytes are no sound model file.
Json describe_model(std::span<const std::byte> bytes, const std::string& name);

}  // namespace egofocus::app
