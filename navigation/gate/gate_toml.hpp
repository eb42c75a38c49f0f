#pragma once
// The tables [gate] and [[scanner]] of the files of programs that drive a body.
// config/navigation/controller.toml explains their keys.

#include <string>

#include "musher/base/toml/table_reader.hpp"
#include "musher/navigation/gate/motion_gate.hpp"

namespace musher::navigation {

// `scan`: the topic of the only scanner, at the middle of the body, where the file has no table
// [[scanner]]; empty: there is none.
std::vector<ScanMount> ReadScanners(config_toml::TableReader& reader, const std::string& scan);

// The table [gate], if there is one; what it leaves out stays.
void ReadGate(config_toml::TableReader& reader, GateRules& rules);

}  // namespace musher::navigation
