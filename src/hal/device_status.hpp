// What an errno of a device means to a user.
#pragma once

#include <cerrno>

#include "egofocus/status.hpp"

namespace egofocus {

/// kNoPermission, kDeviceBusy, kDeviceLost or kIo; ok for 0. Thread: any. RT: yes.
inline Status device_status(int error, const char* subject) noexcept {
  switch (error) {
    case 0:
      return {};
    case EACCES:
    case EPERM:
      return {StatusCode::kNoPermission, subject, error};
    case EBUSY:
      return {StatusCode::kDeviceBusy, subject, error};
    case ENODEV:
    case ENXIO:
      return {StatusCode::kDeviceLost, subject, error};
    default:
      return {StatusCode::kIo, subject, error};
  }
}

}  // namespace egofocus
