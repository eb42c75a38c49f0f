// musher-record play: publishes what a file has.

#include "musher/base/joined.hpp"
#include "musher/base/words.hpp"
#include "musher/transport/linux_event_loop.hpp"
#include "musher/view/record/commands.hpp"
#include "musher/view/record/mcap_source.hpp"
#include "musher/view/record/player.hpp"

namespace musher::view {
namespace {

Result<std::unique_ptr<McapSource>> OpenSource(const PlayCommandOptions& options) {
  auto choice = TopicChoice::Of(options.topics, options.exclude, options.where.name_space);
  if (!choice) return choice.error();
  Duration start{};
  if (!options.start.empty()) {
    const auto parsed = DurationFrom(options.start);
    if (!parsed) return parsed.error();
    start = parsed.value();
  }
  auto source = McapSource::Open(options.file, std::move(choice).value(), start, options.machine);
  if (!source) return source.error();
  for (const std::string& pattern : source.value()->choice().Unmatched()) {
    Say("no topic matched " + pattern);
  }
  if (!source.value()->of_machine().empty()) {
    Say("not played, because a robot would obey: " + Joined(source.value()->of_machine()) +
        "; --machine-topics plays them");
  }
  if (!source.value()->untyped().empty()) {
    Say("not played, because their type is not in the file: " + Joined(source.value()->untyped()));
  }
  if (!source.value()->damage().empty()) Say(source.value()->damage());
  if (source.value()->channels().empty()) {
    return Error{kCodeParametersInvalid, options.file + ": there is no topic to be played"};
  }
  return source;
}

}  // namespace

int RunPlay(const PlayCommandOptions& options) {
  const auto signals = EndSignals();
  if (!signals) return Fail(signals.error(), 1);
  auto remapping = Remapping::Of(options.remap);
  if (!remapping) return Fail(remapping.error());
  const auto source = OpenSource(options);
  if (!source) return Fail(source.error());
  transport::LinuxEventLoop loop;
  const auto node = JoinDomain(loop, options.where);
  if (!node) return Fail(node.error());
  PlayOptions play;
  play.rate = options.rate;
  play.loop = options.loop;
  play.clock = !options.no_clock;
  play.remapping = std::move(remapping).value();
  int exit = 0;
  const auto player =
      Player::Start(*node.value(), *source.value(), play, [&](const Result<>& result) {
        if (!result) exit = Fail(result.error(), 1);
        loop.Stop();
      });
  if (!player) return Fail(player.error());
  const auto ending = loop.WhenReadable(signals.value().get(), [&] {
    exit = 130;
    loop.Stop();
  });
  loop.Run();
  if (exit == 0) {
    if (auto flushed = player.value()->Flush(std::chrono::seconds(5)); !flushed) {
      exit = Fail(flushed.error(), 1);
    }
  }
  Say(Counted(player.value()->published(), "message") + " published");
  return exit;
}

}  // namespace musher::view
