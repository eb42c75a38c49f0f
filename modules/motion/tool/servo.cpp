// musher-motion servo: walks for a time.

#include <iostream>
#include <nlohmann/json.hpp>

#include "musher/base/decimal.hpp"
#include "musher/modules/motion/tool/commands.hpp"
#include "musher/modules/motion/tool/speed_stream.hpp"

namespace musher::motion::tool {
namespace {

constexpr int kSlowest = 20;  // how much slower a /clock may run

}  // namespace

ExitCode Run(const GlobalOptions& global, const ServoOptions& options) {
  auto opened = SpeedStream::Open(global, options.id, options.source);
  if (const auto* exit = std::get_if<ExitCode>(&opened)) return *exit;
  SpeedStream& stream = *std::get<std::unique_ptr<SpeedStream>>(opened);
  const auto time = FromSeconds(options.seconds);
  transport::Clock& clock = stream.link().clock();
  const Time end = clock.Now() + time;
  const std::string what = "servo motion " + NameOf(global, options.id);
  const auto exit = stream.Run(
      [&]() -> std::optional<SpeedLimit> {
        if (clock.Now() >= end) return std::nullopt;
        return options.speed;
      },
      kStandingUp + time * kSlowest, what);
  if (exit) return *exit;
  if (global.json) {
    std::cout << nlohmann::json{{"motion_id", options.id}, {"seconds", options.seconds}}.dump(2)
              << std::endl;
  } else {
    std::cout << what << " for " << Decimal(options.seconds, 1) << " s, then stopped" << std::endl;
  }
  return ExitCode::kDone;
}

}  // namespace musher::motion::tool
