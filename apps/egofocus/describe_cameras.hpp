// Event cameras on USB and event sensors on V4L2, as facts.
#pragma once

#include <span>

#include "hal/usb_survey.hpp"
#include "hal/v4l2_list.hpp"
#include "recording/error.hpp"
#include "recording/json.hpp"

namespace egofocus::app {

/// "cameras" (USB) and, where there are some, "sensors" (V4L2): one entry each with what it is, where it is,
/// whether it can be used and, if not, why and what to do.
recording::Json describe_cameras(std::span<const UsbSighting> cameras, std::span<const V4l2Listed> sensors);

/// kOk when at least one camera can be used, kNoDevice when there is none, kDevice when none of them can be
/// used. Thread: any.
recording::ExitCode verdict(std::span<const UsbSighting> cameras, std::span<const V4l2Listed> sensors);

}  // namespace egofocus::app
