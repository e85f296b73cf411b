// MVSEC, the multi-vehicle stereo event camera data set -> a recording folder.
//
//   NAME_data.hdf5   /davis/SIDE/events [n, 4]: x y t p (-1, 1); /davis/SIDE/imu [n, 6]: accel, gyro; imu_ts
//   NAME_gt.hdf5     /davis/left/odometry [n, 4, 4]: the left camera in the world; odometry_ts
//                    /davis/SIDE/depth_image_raw [n, height, width]: metres on the distorted pixels, NaN
//                    unknown; depth_image_raw_ts
//   camchain*.yaml   Kalibr's layout, equidistant; T_cam_imu, T_cn_cnm1
//
// Times are seconds since an epoch. Raw events go with raw depth; nothing rectified is read. Source: the data
// set's pages "Data Format" and "Calibration", and its own writer of the HDF5 files.
#pragma once

#include <filesystem>

#include "recording/conversion.hpp"

namespace egofocus::recording {

/// `input` is NAME_data.hdf5, or a folder with exactly one. The ground truth may be missing; the calibration
/// is ConvertOptions::kalibr or the one camchain*.yaml beside the data. Throws Error.
ConvertReport convert_mvsec(const std::filesystem::path& input, const std::filesystem::path& output,
                            const ConvertOptions& options);

}  // namespace egofocus::recording
