// The model inside the library: the file that EGOFOCUS_EMBED_MODEL named when it was built.
#pragma once

#include <cstddef>
#include <span>

namespace egofocus {

/// As it lies in the file, at a multiple of Model::kAlignment, unchecked; empty where none is embedded.
/// Thread: any. RT: yes.
std::span<const std::byte> embedded_model() noexcept;

}  // namespace egofocus
