// musher-record play: publishes what a file has.

#include <functional>
#include <utility>

#include "musher/base/host.hpp"
#include "musher/base/joined.hpp"
#include "musher/base/words.hpp"
#include "musher/transport/dds/topic_watch.hpp"
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

constexpr Duration kFindRobots = std::chrono::seconds(1);  // before anything is published

// Looks for a robot in the domain as long as it exists: its processes would obey what is played.
class RobotSearch {
 public:
  // `on_found` runs once, on the loop.
  static Result<std::unique_ptr<RobotSearch>> Begin(transport::Node& node, int domain_id,
                                                    std::function<void(const Error&)> on_found) {
    auto search = std::make_unique<RobotSearch>();
    search->on_found_ = std::move(on_found);
    auto watch = transport::WatchTopics(
        node,
        [self = search.get()](const transport::DiscoveredEndpoint& endpoint) {
          if (!endpoint.writer || !IsReportOfRobot(endpoint.type)) return;
          self->Found("publishes " + RosTopic(endpoint.topic));
        },
        [](transport::EndpointId) {});
    if (!watch) return watch.error();
    search->watch_ = std::move(watch).value();
    if (NameLock::IsHeldInDomain(domain_id, "/musher/controller")) {
      search->Found("has its controller on this host");
    }
    return search;
  }

 private:
  void Found(const std::string& what) {
    if (std::exchange(found_, true)) return;
    on_found_({kCodeStateInvalid,
               "a robot is in this domain (it " + what +
                   "), and its processes would obey what is played, such as /cmd_vel and /clock: "
                   "play in another domain (--domain N), or with --beside-a-robot"});
  }

  bool found_ = false;
  std::function<void(const Error&)> on_found_;
  std::unique_ptr<transport::TopicWatch> watch_;
};

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
  const auto ending = loop.WhenReadable(signals.value().get(), [&] {
    exit = 130;
    loop.Stop();
  });
  std::unique_ptr<RobotSearch> search;
  if (!options.beside_a_robot) {
    const auto domain = transport::DomainId({.domain_id = options.where.domain});
    if (!domain) return Fail(domain.error());
    auto begun = RobotSearch::Begin(*node.value(), domain.value(), [&](const Error& robot) {
      exit = Fail(robot, 1);
      loop.Stop();
    });
    if (!begun) return Fail(begun.error());
    search = std::move(begun).value();
    loop.RunUntil([&] { return exit != 0; }, loop.Now() + kFindRobots);
    if (exit != 0) return exit;
  }
  const auto player =
      Player::Start(*node.value(), *source.value(), play, [&](const Result<>& result) {
        if (!result) exit = Fail(result.error(), 1);
        loop.Stop();
      });
  if (!player) return Fail(player.error());
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
