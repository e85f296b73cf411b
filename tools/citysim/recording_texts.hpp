// The text files of a recording: everything but events and pictures.
#pragma once

#include <map>
#include <string>

#include "citysim/film.hpp"
#include "citysim/recording_writer.hpp"

namespace egofocus::citysim {

/// Name in the folder -> content.
[[nodiscard]] std::map<std::string, std::string> recording_texts(const World& world,
                                                                 const RecordingOptions& options,
                                                                 double duration_s);

/// citysim.json
[[nodiscard]] std::string recording_facts(const World& world, const RecordingOptions& options,
                                          const RecordingReport& report, const DvsCounters& sensor);

}  // namespace egofocus::citysim
