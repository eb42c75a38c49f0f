#pragma once
// The config of musher-vp-engine, a TOML file; every key is explained in
// config/vp_engine/vp_engine.toml. Reading reports all errors at once, with line and column.

#include <string>
#include <string_view>

#include "musher/base/time.hpp"
#include "musher/base/toml/parsed.hpp"

namespace musher::vp_engine {

struct VpConfig {
  std::string folder{};    // of the programs, absolute
  std::string examples{};  // a folder of programs that are only read, absolute; empty: none
  double rate_hz = 50;
  int groot2_port = 0;  // 0: none
  std::string groot2_address = "127.0.0.1";
  bool groot2_hooks = false;  // Groot2 may hold and replace nodes
  std::string record{};       // relative to the machine's state_dir; empty: none
  std::size_t record_mib = 16;
  std::string speech = "speech_text_play";
  std::string motion = "motion_result_cmd";
  std::string light = "led_execute";
  Duration speech_time = Milliseconds(15'000);  // until a call has failed
  Duration motion_time = Milliseconds(70'000);
  Duration light_time = Milliseconds(2'000);
};

// Never throws; an unreadable file is a diagnostic.
Parsed<VpConfig> ReadVpFile(const std::string& path);
// The same for a text; `path` is what diagnostics refer to, and relative paths are in its folder.
Parsed<VpConfig> ReadVpText(std::string_view text, const std::string& path);

}  // namespace musher::vp_engine
