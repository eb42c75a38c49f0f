#include "musher/modules/world/process/world_control.hpp"

#include <charconv>
#include <cmath>
#include <map>
#include <memory>
#include <optional>

#include "musher/base/toml/names.hpp"
#include "musher/messages/geometry_msgs/geometry.hpp"
#include "musher/messages/musher_msgs/actuator_status.hpp"
#include "musher/messages/std_msgs/basic.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/messages/std_srvs/set_bool.hpp"
#include "musher/messages/std_srvs/trigger.hpp"
#include "musher/transport/dds/dds_node.hpp"
#include "musher/transport/directed_publisher.hpp"
#include "musher/transport/linux_event_loop.hpp"
#include "musher/transport/service.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::world {

const char* const kWorldCommands =
    "  battery PERCENT     how full the battery is; battery PERCENT ROBOT: of a robot\n"
    "  cable in|out        the charging cable\n"
    "  touch KIND          single, double, hold, circle, or a number from 1 to 17\n"
    "  say TEXT...         a person speaks TEXT to the robot\n"
    "  power-key down|up   the power key: held for 3 s the robot is powered off\n"
    "  fault NAME [MOTOR]  of the body or a sensor: see the module's README\n"
    "  place X Y [YAW]     moves the body there, m and rad; place X Y YAW ROBOT: a robot\n"
    "  odometry WHAT       of a robot: freeze ROBOT, jump X Y ROBOT by so many m, right ROBOT\n"
    "  map objects|fixed   the map comes again, with the objects in it, or without them\n"
    "  speed FACTOR        how fast the world's time goes\n"
    "  pause on|off        whether it stands still\n"
    "  show|hide NAME      a ball with that name appears, or disappears\n"
    "  mark TEXT...        marks this moment with TEXT in the charts of the picture\n"
    "  draw                writes the picture, prints its path\n"
    "  referee [--json]    prints the referee's report of this run\n"
    "  robots [--json]     prints pose, battery, load and collisions of each robot\n"
    "  field               prints pose, wheels, boxes and events on a field, as JSON";

namespace {

using Words = std::vector<std::string>;

std::optional<double> Number(const std::string& word) {
  double number = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
  if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(number)) {
    return std::nullopt;
  }
  return number;
}

std::optional<bool> Either(const std::string& word, const char* yes, const char* no) {
  if (word == yes) return true;
  if (word == no) return false;
  return std::nullopt;
}

// The numbers of TouchStatus.
std::optional<int> TouchKind(const std::string& word) {
  static const std::map<std::string, int> kinds = {
      {"single", 1}, {"double", 3}, {"hold", 7}, {"circle", 8}};
  if (const auto found = kinds.find(word); found != kinds.end()) return found->second;
  const auto number = Number(word);
  if (!number || *number < 1 || *number > kMostTouchState || std::trunc(*number) != *number) {
    return std::nullopt;
  }
  return static_cast<int>(*number);
}

std::optional<WorldCommand> ReadPlace(const Words& words) {
  if (words.size() < 3 || words.size() > 5) return std::nullopt;
  const auto x = Number(words[1]);
  const auto y = Number(words[2]);
  const auto yaw = words.size() >= 4 ? Number(words[3]) : 0.0;
  if (!x || !y || !yaw) return std::nullopt;
  if (words.size() == 5) {
    if (!config_toml::IsName(words[4])) return std::nullopt;
    return CarryRobot{words[4], {{*x, *y}, *yaw}};
  }
  return Carry{{{*x, *y}, *yaw}};
}

std::optional<WorldCommand> ReadOdometry(const Words& words) {
  const bool jump = words.size() == 5 && words[1] == "jump";
  const bool plain = words.size() == 3 && (words[1] == "freeze" || words[1] == "right");
  if (jump && (!Number(words[2]) || !Number(words[3]))) return std::nullopt;
  if ((!jump && !plain) || !config_toml::IsName(words.back())) return std::nullopt;
  return OdometryNow{words.back(), jump ? "jump " + words[2] + " " + words[3] : words[1]};
}

std::optional<WorldCommand> ReadOne(const std::string& what, const std::string& word) {
  if (what == "battery" || what == "speed") {
    const auto number = Number(word);
    if (!number) return std::nullopt;
    return what == "speed" ? WorldCommand(Speed{*number}) : WorldCommand(ChargeTo{*number});
  }
  if (what == "cable") {
    if (const auto in = Either(word, "in", "out")) return Cable{*in};
  } else if (what == "power-key") {
    if (const auto down = Either(word, "down", "up")) return PowerKey{*down};
  } else if (what == "pause") {
    if (const auto on = Either(word, "on", "off")) return Pause{*on};
  } else if (what == "map") {
    if (const auto objects = Either(word, "objects", "fixed")) return MapNow{*objects};
  } else if (what == "show" || what == "hide") {
    return Show{word, what == "show"};
  } else if (what == "touch") {
    if (const auto kind = TouchKind(word)) return Touch{*kind};
  }
  return std::nullopt;
}

std::optional<WorldCommand> ReadWords(const Words& words) {
  if (words.empty()) return std::nullopt;
  const std::string& what = words.front();
  if (what == "place") return ReadPlace(words);
  if (what == "odometry") return ReadOdometry(words);
  if (what == "battery" && words.size() == 3 && config_toml::IsName(words[2])) {
    const auto percent = Number(words[1]);
    return percent ? std::optional<WorldCommand>(ChargeRobot{words[2], *percent}) : std::nullopt;
  }
  if (what == "draw" && words.size() == 1) return DrawNow{};
  const bool json = words.size() == 2 && words[1] == "--json";
  if (what == "referee" && (json || words.size() == 1)) return RefereeNow{json};
  if (what == "robots" && (json || words.size() == 1)) return RobotsNow{json};
  if (what == "field" && (json || words.size() == 1)) return FieldNow{};
  if ((what == "say" || what == "mark") && words.size() > 1) {
    std::string text = words[1];
    for (std::size_t i = 2; i < words.size(); ++i) text += " " + words[i];
    return what == "say" ? WorldCommand(Speech{text}) : WorldCommand(MarkNow{text});
  }
  if (what == "fault" && (words.size() == 2 || words.size() == 3)) {
    return Fault{words[1] + (words.size() == 3 ? " " + words[2] : "")};
  }
  return words.size() == 2 ? ReadOne(what, words[1]) : std::nullopt;
}

class CommandSender {
 public:
  CommandSender(transport::EventLoop& loop, transport::Node& node, std::string name_space,
                Duration timeout)
      : loop_(loop),
        node_(node),
        name_space_(std::move(name_space)),
        deadline_(loop.Now() + timeout) {}

  Result<std::string> operator()(const ChargeTo& command) {
    return Publish<msg::Float32>("set_battery", {static_cast<float>(command.percent)});
  }
  Result<std::string> operator()(const Cable& command) {
    return Call<msg::SetBool>("charge", {command.in});
  }
  Result<std::string> operator()(const Touch& command) {
    return Publish<msg::Int32>("press", {command.state});
  }
  Result<std::string> operator()(const Speech& command) {
    return PublishToActuator<msg::String>("speech_text", {command.text});
  }
  Result<std::string> operator()(const PowerKey& command) {
    return PublishToActuator<msg::Bool>("power_key", {command.down});
  }
  Result<std::string> operator()(const Fault& command) {
    return Publish<msg::String>("fault", {command.text});
  }
  Result<std::string> operator()(const Carry& command) {
    return Publish<msg::PoseStamped>("place", ToPoseStamped(command.at));
  }
  Result<std::string> operator()(const ChargeRobot& command) {
    return Publish<msg::Float32>(command.robot + "/set_battery",
                                 {static_cast<float>(command.percent)});
  }
  Result<std::string> operator()(const CarryRobot& command) {
    return Publish<msg::PoseStamped>(command.robot + "/place", ToPoseStamped(command.at));
  }
  Result<std::string> operator()(const OdometryNow& command) {
    return Publish<msg::String>(command.robot + "/odometry", {command.text});
  }
  Result<std::string> operator()(const MapNow& command) {
    return Call<msg::SetBool>("map", {command.objects});
  }
  Result<std::string> operator()(const Speed& command) {
    return Publish<msg::Float32>("speed", {static_cast<float>(command.factor)});
  }
  Result<std::string> operator()(const Show& command) {
    return Publish<msg::String>(command.shown ? "show" : "hide", {command.name});
  }
  Result<std::string> operator()(const MarkNow& command) {
    return Publish<msg::String>("mark", {command.text});
  }
  Result<std::string> operator()(const Pause& command) {
    return Call<msg::SetBool>("pause", {command.on});
  }
  Result<std::string> operator()(const DrawNow&) { return Call<msg::Trigger>("draw", {}); }
  Result<std::string> operator()(const RefereeNow& command) {
    return Call<msg::Trigger>(command.json ? "referee_json" : "referee", {});
  }
  Result<std::string> operator()(const RobotsNow& command) {
    return Call<msg::Trigger>(command.json ? "robots_json" : "robots", {});
  }
  Result<std::string> operator()(const FieldNow&) { return Call<msg::Trigger>("field", {}); }

 private:
  static msg::PoseStamped ToPoseStamped(const Pose2& at) {
    msg::PoseStamped pose;
    pose.pose.position.x = at.position_m.x();
    pose.pose.position.y = at.position_m.y();
    pose.pose.orientation.z = std::sin(at.yaw_rad / 2);
    pose.pose.orientation.w = std::cos(at.yaw_rad / 2);
    return pose;
  }

  std::string Name(const std::string& name) const {
    return transport::ResolveName(name_space_, "world/" + name);
  }

  Error NoWorld() const {
    return {kCodeTimeout, "no world answers" +
                              (name_space_.empty() ? "" : " in namespace " + name_space_) +
                              "; is `musher up` running, in the same domain?"};
  }

  template <class M>
  Result<std::string> Publish(const std::string& topic, const M& message) {
    const auto publisher = transport::MakeDirectedPublisher<M>(
        node_, Name(topic), transport::ServerOf<msg::Trigger>(Name("draw")));
    if (!publisher) return publisher.error();
    return Send(publisher.value(), message, NoWorld());
  }

  // To an actuator of the robot: what the world does not read itself, but another module does. A
  // recorder of the topic is none.
  template <class M>
  Result<std::string> PublishToActuator(const std::string& topic, const M& message) {
    const auto publisher = transport::MakeDirectedPublisher<M>(
        node_, Name(topic),
        transport::PublisherOf<msg::ActuatorStatus>(transport::ActuatorStatusTopic(name_space_)));
    if (!publisher) return publisher.error();
    return Send(publisher.value(), message,
                {kCodeTimeout, "no actuator reads " + Name(topic) +
                                   "; is the module up that does, in the same domain?"});
  }

  template <class M>
  Result<std::string> Send(const std::unique_ptr<transport::DirectedPublisher<M>>& publisher,
                           const M& message, const Error& no_reader) {
    if (!loop_.RunUntil([&] { return publisher->Ready(); }, deadline_)) return no_reader;
    if (auto sent = publisher->Publish(message); !sent) return sent.error();
    if (auto got = publisher->Flush(deadline_ - loop_.Now()); !got) return got.error();
    return std::string();
  }

  template <class S>
  Result<std::string> Call(const std::string& service, const typename S::Request& request) {
    auto client = transport::MakeClient<S>(node_, Name(service));
    if (!client) return client.error();
    std::optional<Result<typename S::Response>> answer;
    client.value()->Call(request, deadline_ - loop_.Now(),
                         [&](auto response) { answer.emplace(std::move(response)); });
    loop_.RunUntil([&] { return answer.has_value(); }, deadline_ + Milliseconds(100));
    if (!answer || !*answer) return NoWorld();
    const auto& response = answer->value();
    if (!response.success) return Error{kCodeFailed, response.message};
    return response.message;
  }

  transport::EventLoop& loop_;
  transport::Node& node_;
  const std::string name_space_;
  const Time deadline_;
};

}  // namespace

Result<WorldCommand> ParseWorldCommand(const Words& words) {
  if (const auto command = ReadWords(words)) return *command;
  std::string command_line;
  for (const std::string& word : words) command_line += " " + word;
  return Error{kCodeParametersInvalid,
               "unknown command `send" + command_line + "`; the commands are\n" + kWorldCommands};
}

Result<std::string> SendWorldCommand(const WorldCommand& command, const std::string& name_space,
                                     Duration timeout) {
  transport::LinuxEventLoop loop;
  transport::DdsOptions options;
  options.discovery = transport::DiscoveryTiming::kAtOnce;
  options.hidden = true;
  auto node = transport::MakeDdsNode(loop, options);
  if (!node) return node.error();
  return std::visit(CommandSender(loop, *node.value(), name_space, timeout), command);
}

}  // namespace musher::world
