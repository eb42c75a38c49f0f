#pragma once
// The file of musher-meilin-server; the files in config/meilin explain the keys.

#include <memory>
#include <string>
#include <string_view>
#include <variant>

#include "musher/base/toml/parsed.hpp"
#include "musher/modules/meilin/servers/move_server.hpp"
#include "musher/modules/meilin/servers/suspension_server.hpp"
#include "musher/modules/meilin/servers/tool_server.hpp"

namespace musher::meilin::servers {

struct ServerConfig {
  Duration self_check_time = Milliseconds(5000);  // real time until the hardware is there
  std::variant<MoveConfig, SuspensionConfig, ArmConfig, SpearConfig> server;
};

// Never throws; an unreadable file is a diagnostic.
Parsed<ServerConfig> ReadServerFile(const std::string& path);

// The same for a text; `path` is what diagnostics refer to.
Parsed<ServerConfig> ReadServerText(std::string_view text, const std::string& path);

// The server of a config; on the loop.
Result<std::unique_ptr<Server>> Make(const Dependencies& dependencies, const ServerConfig& config);

}  // namespace musher::meilin::servers
