// musher-audio say TEXT, play ID: plays to the end, or at once with an interrupt.

#include <iostream>
#include <nlohmann/json.hpp>

#include "musher/messages/protocol/audio.hpp"
#include "musher/modules/audio/tool/call.hpp"
#include "musher/transport/directed_publisher.hpp"

namespace musher::audio::tool {
namespace {

constexpr const char* kModuleName = "musher-audio";

void Print(const GlobalOptions& global, int status, std::int32_t code, const std::string& text) {
  if (global.json) {
    const nlohmann::json document = {{"status", status}, {"code", code}, {"text", text}};
    std::cout << document.dump(2) << std::endl;
  } else if (code == kCodeOk) {
    std::cout << text << std::endl;
  }
}

ExitCode PlayNow(const GlobalOptions& global, const PlayOptions& options, program::ToolLink& link) {
  const auto publisher = transport::MakeDirectedPublisher<msg::AudioPlayExtend>(
      link.node(), link.Name("speech_play_extend"),
      transport::ServerOf<msg::AudioTextPlay>(link.Name("speech_text_play")));
  if (!publisher) return Fail(ExitCode::kUsage, publisher.error());
  if (!link.Find([&] { return publisher.value()->Ready(); })) {
    if (link.interrupted()) return Fail(ExitCode::kInterrupted, {kCodeFailed, "interrupted"});
    return Fail(ExitCode::kNotDone, link.NotFound("audio module"));
  }
  const Result<> sent = publisher.value()->Publish({kModuleName,
                                                    options.text.has_value(),
                                                    {kModuleName, options.play_id},
                                                    options.text.value_or("")});
  if (!sent) return Fail(ExitCode::kNotDone, sent.error());
  const Result<> taken = publisher.value()->Flush(link.discovery());
  if (!taken) return Fail(ExitCode::kNotDone, taken.error());
  Print(global, msg::AudioTextPlay::kFinished, kCodeOk, "sent");
  return ExitCode::kDone;
}

}  // namespace

ExitCode Run(const GlobalOptions& global, const PlayOptions& options) {
  const auto link = program::ToolLink::Open(global);
  if (!link) return Fail(ExitCode::kUsage, link.error());
  if (options.now) return PlayNow(global, options, *link.value());
  const auto end = Call<msg::AudioTextPlay>(*link.value(), "speech_text_play",
                                            {kModuleName,
                                             options.text.has_value(),
                                             {kModuleName, options.play_id},
                                             options.text.value_or("")});
  if (!end.reply) return Fail(end.exit, end.error);
  const bool done = end.reply->status == msg::AudioTextPlay::kFinished;
  Print(global, end.reply->status, end.reply->code,
        done ? "played to the end" : CodeMeaning(end.reply->code));
  if (done) return ExitCode::kDone;
  return Fail(ExitCode::kNotDone, {end.reply->code, CodeMeaning(end.reply->code)});
}

}  // namespace musher::audio::tool
