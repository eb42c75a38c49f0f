// musher-record play: publishes what a file has.

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
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
    Print("no topic matched " + pattern);
  }
  if (!source.value()->of_machine().empty()) {
    Print("not played, because a robot would obey: " + Joined(source.value()->of_machine()) +
          "; --machine-topics plays them");
  }
  if (!source.value()->untyped().empty()) {
    Print("not played, because their type is not in the file: " +
          Joined(source.value()->untyped()));
  }
  if (!source.value()->damage().empty()) Print(source.value()->damage());
  if (source.value()->channels().empty()) {
    return Error{kCodeParametersInvalid, options.file + ": there is no topic to be played"};
  }
  return source;
}

constexpr Duration kFindRobots = std::chrono::seconds(1);  // before anything is published
constexpr Duration kNameWithin = Milliseconds(300);        // from a reader to the name of its node

bool IsViewerOfMusher(const transport::PeerInfo& peer) {
  if (peer.pid == 0 || peer.host != HostName()) return false;
  std::error_code error;
  const auto program =
      std::filesystem::read_symlink("/proc/" + std::to_string(peer.pid) + "/exe", error).filename();
  return program == "musher" || program == "musher-view" || program == "musher-record";
}

// Looks for a robot in the domain as long as it exists: its processes would obey what is played. It
// may have no controller: a driver that reads a recorded command moves by it, too.
class RobotSearch {
 public:
  explicit RobotSearch(transport::Node& node) : node_(node) {}

  // `commands`: the played ones, as DDS names them: "rt/cmd_vel". `on_found` runs once, on the
  // loop.
  static Result<std::unique_ptr<RobotSearch>> Begin(transport::Node& node, int domain_id,
                                                    std::set<std::string> commands,
                                                    std::function<void(const Error&)> on_found) {
    auto search = std::make_unique<RobotSearch>(node);
    search->commands_ = std::move(commands);
    search->on_found_ = std::move(on_found);
    auto watch = transport::WatchTopics(
        node,
        [self = search.get()](const transport::DiscoveredEndpoint& endpoint) {
          if (endpoint.writer && IsReportOfRobot(endpoint.type)) {
            self->Found("publishes " + RosTopic(endpoint.topic));
          } else if (!endpoint.writer && self->commands_.contains(endpoint.topic)) {
            self->OnReader(endpoint);
          }
        },
        [self = search.get()](transport::EndpointId id) {
          self->readers_.erase(id);
          self->unnamed_.erase(id);
        });
    if (!watch) return watch.error();
    search->watch_ = std::move(watch).value();
    if (NameLock::IsHeldInDomain(domain_id, "/musher/controller")) {
      search->Found("has its controller on this host");
    }
    return search;
  }

  // Whether it is known of each reader of a command what it is.
  bool settled() const { return unnamed_.empty(); }

 private:
  // The name of its node is discovered after it.
  void OnReader(const transport::DiscoveredEndpoint& endpoint) {
    transport::EventLoop& loop = node_.loop();
    unnamed_.insert(endpoint.id);
    readers_[endpoint.id] =
        loop.At(loop.Now() + kNameWithin,
                [this, id = endpoint.id, reader = endpoint.participant,
                 topic = RosTopic(endpoint.topic)] { OnNamedReader(id, reader, topic); });
  }
  // Tools that show or record what they read move nothing.
  void OnNamedReader(transport::EndpointId id, transport::ParticipantId reader,
                     const std::string& topic) {
    if (!readers_.contains(id)) return;
    unnamed_.erase(id);
    std::string name = node_.RosNodeOf(reader);
    for (const transport::PeerInfo& peer : node_.Peers()) {
      if (peer.id != reader || !name.empty()) continue;
      if (IsViewerOfMusher(peer)) return;
      name = peer.name;
      if (name.empty() && peer.pid != 0) {
        name =
            "process " + std::to_string(peer.pid) + (peer.host.empty() ? "" : " of " + peer.host);
      }
    }
    if (IsViewer(name) || std::exchange(found_, true)) return;
    on_found_({kCodeStateInvalid,
               (name.empty() ? "a process" : name) + " reads " + topic +
                   ", and may move by what is played: play in another domain (--domain N), "
                   "without it (--exclude " +
                   topic + "), under another name (--remap " + topic + ":=/played" + topic +
                   "), or with --beside-a-robot"});
  }
  void Found(const std::string& what) {
    if (std::exchange(found_, true)) return;
    on_found_({kCodeStateInvalid,
               "a robot is in this domain (it " + what +
                   "), and its processes would obey what is played, such as /cmd_vel and /clock: "
                   "play in another domain (--domain N), or with --beside-a-robot"});
  }

  transport::Node& node_;
  std::set<std::string> commands_;
  bool found_ = false;
  std::function<void(const Error&)> on_found_;
  std::map<transport::EndpointId, transport::LoopHandlePtr> readers_;  // of commands
  std::set<transport::EndpointId> unnamed_;                            // of readers_
  std::unique_ptr<transport::TopicWatch> watch_;
};

}  // namespace

int RunPlay(const PlayCommandOptions& options) {
  const auto signals = EndSignals();
  if (!signals) return Fail(signals.error(), 1);
  auto remapping = TopicNames::Of(options.remap);
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
    std::set<std::string> commands;
    for (const PlayedChannel& channel : source.value()->channels()) {
      const std::string name = play.remapping.NameOf(channel.topic);
      if (IsCommand(name, channel.type)) commands.insert("rt" + name);
    }
    auto begun = RobotSearch::Begin(*node.value(), domain.value(), std::move(commands),
                                    [&](const Error& robot) {
                                      exit = Fail(robot, 1);
                                      loop.Stop();
                                    });
    if (!begun) return Fail(begun.error());
    search = std::move(begun).value();
    loop.RunUntil([&] { return exit != 0; }, loop.Now() + kFindRobots);
    loop.RunUntil([&] { return exit != 0 || search->settled(); }, loop.Now() + 2 * kNameWithin);
    if (exit != 0) return exit;
    play.withholds_commands = [&search] { return !search->settled(); };
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
  Print(Counted(player.value()->published(), "message") + " published");
  return exit;
}

}  // namespace musher::view
