// The simulator's recording as files: what fixtures/planes holds.
#pragma once

#include <map>
#include <string>

#include "support/plane_simulator.hpp"

namespace egofocus::sim {

/// File name -> content of the text files.
std::map<std::string, std::string> planes_texts(const PlaneSimulator& simulator);

/// Times of the depth pictures: each tick from the first with a full period behind it to the end.
std::vector<std::int64_t> planes_ticks(const PlaneSimulator& simulator);

/// camera.toml of the fixture: the simulator's camera and the roles of vehicle_dbc().
recording::CameraFile planes_camera(const PlaneSimulator& simulator);

}  // namespace egofocus::sim
