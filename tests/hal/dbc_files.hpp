// DBC text for tests. A Dbc is too large for a small stack, so it comes on the heap.
#pragma once

#include <catch2/catch.hpp>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>

#include "hal/dbc.hpp"
#include "support/source_dir.hpp"

inline std::unique_ptr<egofocus::Dbc> read_dbc_text(const std::string& text) {
  auto dbc = std::make_unique<egofocus::Dbc>();
  const egofocus::Status status = egofocus::read_dbc(text, {}, *dbc);
  char message[200];
  status.describe(message);
  INFO(message);
  REQUIRE(status.ok());
  return dbc;
}

/// One of dbc/, the files that are installed.
inline std::unique_ptr<egofocus::Dbc> read_shipped_dbc(const std::string& name) {
  std::ifstream file(egofocus::test::source_dir() + "/dbc/" + name, std::ios::binary);
  REQUIRE(file.good());
  return read_dbc_text({std::istreambuf_iterator<char>(file), {}});
}
