// musher-audio stop, volume [N].

#include <iostream>
#include <nlohmann/json.hpp>

#include "musher/messages/protocol/audio.hpp"
#include "musher/messages/std_srvs/empty.hpp"
#include "musher/modules/audio/tool/call.hpp"

namespace musher::audio::tool {

ExitCode Run(const GlobalOptions& global, const StopOptions&) {
  const auto link = program::ToolLink::Open(global);
  if (!link) return Fail(ExitCode::kUsage, link.error());
  const auto end = Call<msg::EmptyService>(*link.value(), "stop_play", {});
  if (!end.reply) return Fail(end.exit, end.error);
  if (global.json) {
    std::cout << nlohmann::json{{"text", "silent"}}.dump(2) << std::endl;
  } else {
    std::cout << "silent" << std::endl;
  }
  return ExitCode::kDone;
}

ExitCode Run(const GlobalOptions& global, const VolumeOptions& options) {
  const auto link = program::ToolLink::Open(global);
  if (!link) return Fail(ExitCode::kUsage, link.error());
  if (options.percent) {
    const auto end = Call<msg::AudioVolumeSet>(*link.value(), "audio_volume_set",
                                               {static_cast<std::uint8_t>(*options.percent)});
    if (!end.reply) return Fail(end.exit, end.error);
    const std::int32_t code = end.reply->code;
    if (!end.reply->success) return Fail(ExitCode::kNotDone, {code, CodeMeaning(code)});
  }
  const auto end = Call<msg::AudioVolumeGet>(*link.value(), "audio_volume_get", {});
  if (!end.reply) return Fail(end.exit, end.error);
  const int volume = end.reply->volume;
  if (global.json) {
    std::cout << nlohmann::json{{"volume", volume}}.dump(2) << std::endl;
  } else {
    std::cout << "volume " << volume << " %" << std::endl;
  }
  return ExitCode::kDone;
}

}  // namespace musher::audio::tool
