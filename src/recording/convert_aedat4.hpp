// AEDAT 4.0 (iniVation's DV) -> a recording folder: events and IMU. Pictures and triggers are left out.
#pragma once

#include <filesystem>

#include "recording/conversion.hpp"

namespace egofocus::recording {

/// The format has no calibration: ConvertOptions::kalibr is needed. Of several event streams the first is the
/// left camera's, the second the right one's; the IMU is that of the same place in the list. Throws Error.
ConvertReport convert_aedat4(const std::filesystem::path& input, const std::filesystem::path& output,
                             const ConvertOptions& options);

}  // namespace egofocus::recording
