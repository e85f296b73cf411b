#include "recording/convert.hpp"

#include <fstream>
#include <string>
#include <utility>

#include "recording/aedat4_reader.hpp"
#include "recording/convert_aedat4.hpp"
#include "recording/convert_dsec.hpp"
#include "recording/convert_ecd.hpp"
#include "recording/convert_mvsec.hpp"
#include "recording/error.hpp"
#include "recording/hdf5_file.hpp"

namespace egofocus::recording {
namespace {

namespace fs = std::filesystem;

constexpr std::pair<std::string_view, InputFormat> kNames[] = {{"ecd", InputFormat::kEcd},
                                                               {"mvsec", InputFormat::kMvsec},
                                                               {"dsec", InputFormat::kDsec},
                                                               {"aedat4", InputFormat::kAedat4}};

InputFormat guess_folder(const fs::path& input) {
  if (!find_dsec_events(input).empty()) return InputFormat::kDsec;
  for (const fs::directory_entry& entry : fs::directory_iterator(input)) {
    if (entry.path().filename().string().ends_with("_data.hdf5")) return InputFormat::kMvsec;
  }
  return InputFormat::kEcd;
}

/// An option that a format has no use for would be lost without a word.
void refuse_unused(InputFormat format, const ConvertOptions& options) {
  const bool has_calibration = format == InputFormat::kEcd || format == InputFormat::kDsec;
  if (has_calibration && !options.kalibr.empty())
    throw Error(ExitCode::kUsage, "--kalibr", "this layout has a calibration of its own. Leave it out.");
  if (format == InputFormat::kEcd && options.camera == CameraSide::kRight)
    throw Error(ExitCode::kUsage, "--camera", "a text set has one camera. Leave it out.");
}

template <typename Work>
auto guarded(const Work& work) {
  try {
    return work();
  } catch (const fs::filesystem_error& error) {
    throw refused(error);
  }
}

}  // namespace

std::optional<InputFormat> input_format_of(std::string_view name) {
  for (const auto& [known, format] : kNames) {
    if (known == name) return format;
  }
  return {};
}

InputFormat guess_format(const fs::path& input) {
  return guarded([&] {
    if (fs::is_directory(input)) return guess_folder(input);
    if (is_hdf5(input)) return InputFormat::kMvsec;
    std::ifstream file(input, std::ios::binary);
    if (!file)
      throw Error(ExitCode::kFile, input.string(), "cannot be opened. Check the path and the permissions.");
    std::string head(16, '\0');
    file.read(head.data(), static_cast<std::streamsize>(head.size()));
    if (is_aedat4(head)) return InputFormat::kAedat4;
    throw Error(
        ExitCode::kBadFile, input.string(),
        "is of no known layout (ECD, MVSEC and DSEC are folders, AEDAT4 is a file). Name it with --format.");
  });
}

ConvertReport convert(InputFormat format, const fs::path& input, const fs::path& output,
                      const ConvertOptions& options) {
  refuse_unused(format, options);
  return guarded([&] {
    switch (format) {
      case InputFormat::kMvsec:
        return convert_mvsec(input, output, options);
      case InputFormat::kDsec:
        return convert_dsec(input, output, options);
      case InputFormat::kAedat4:
        return convert_aedat4(input, output, options);
      case InputFormat::kEcd:
        break;
    }
    return convert_ecd(input, output, options);
  });
}

}  // namespace egofocus::recording
