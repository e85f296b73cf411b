// The subcommands. Each adds itself to the program and runs as a callback; errors leave as recording::Error.
#pragma once

#include <CLI/CLI.hpp>

namespace egofocus::app {

void add_convert(CLI::App& program);
void add_devices(CLI::App& program);
void add_eval(CLI::App& program);
void add_info(CLI::App& program);
void add_overlay(CLI::App& program);
void add_replay(CLI::App& program);

}  // namespace egofocus::app
