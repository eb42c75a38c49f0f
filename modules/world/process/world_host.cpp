#include "musher/modules/world/process/world_host.hpp"

#include <algorithm>
#include <array>
#include <iterator>
#include <sstream>
#include <utility>

#include "musher/messages/geometry_msgs/geometry.hpp"
#include "musher/messages/musher_msgs/machine_status.hpp"
#include "musher/messages/stamp.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/messages/std_srvs/set_bool.hpp"
#include "musher/messages/std_srvs/trigger.hpp"
#include "musher/modules/world/picture/picture.hpp"
#include "musher/modules/world/process/world_messages.hpp"
#include "musher/transport/clock.hpp"

namespace musher::world {

using transport::kLatchedFromManyQos;
using transport::kLatchedQos;

WorldHost::WorldHost(transport::Node& node, Scene scene, HostOptions options)
    : node_(node),
      options_(std::move(options)),
      world_(std::move(scene)),
      pacer_(kStep, world_.scene().speed, node.loop().Now()) {}

WorldHost::~WorldHost() = default;

Result<std::unique_ptr<WorldHost>> WorldHost::Start(transport::Node& node, Scene scene,
                                                    HostOptions options) {
  std::unique_ptr<WorldHost> host(new WorldHost(node, std::move(scene), std::move(options)));
  if (auto connected = host->Connect(); !connected) return connected.error();
  host->SetSpeed(host->world_.scene().speed);
  return host;
}

Result<> WorldHost::Connect() {
  for (const auto connect : {&WorldHost::Publish, &WorldHost::Listen, &WorldHost::Serve}) {
    if (auto connected = (this->*connect)(); !connected) return connected;
  }
  return Ok();
}

Result<> WorldHost::Publish() {
  auto clock =
      transport::MakePublisher<msg::Clock>(node_, transport::kClockTopic, transport::kClockQos);
  if (!clock) return clock.error();
  clock_ = std::move(clock).value();
  if (auto made = Make(body_state_, "world/body_state"); !made) return made;
  if (auto made = Make(battery_, "world/battery"); !made) return made;
  if (auto made = Make(touch_, "world/touch"); !made) return made;
  auto sensors = WorldSensors::Make(node_, world_.scene(), options_.name_space);
  if (!sensors) return sensors.error();
  sensors_ = std::move(sensors).value();
  auto show = WorldShow::Make(node_, world_, options_.name_space, options_.log);
  if (!show) return show.error();
  show_ = std::move(show).value();
  return MakeCameras();
}

Result<> WorldHost::MakeCameras() {
  const auto go_on = [this] {
    if (std::exchange(late_, false) && !pacer_.paused()) OnStep();
  };
  auto cameras = WorldCameras::Make(node_, world_.scene(),
                                    {options_.name_space, options_.log, options_.shooter, go_on});
  if (!cameras) return cameras.error();
  cameras_ = std::move(cameras).value();
  return Ok();
}

Result<> WorldHost::Listen() {
  const std::array results = {
      On<msg::MotionCustomCommand>("world/body_command",
                                   [this](const auto& message) {
                                     const auto command = FromMessage(message);
                                     Log(command ? world_.Command(command.value())
                                                 : "a body command is refused: " +
                                                       command.error().message);
                                   }),
      On<msg::Float32>("world/set_battery",
                       [this](const auto& message) { Log(world_.SetBattery(message.data)); }),
      On<msg::Int32>("world/press", [this](const auto& message) { Touch(message.data); }),
      On<msg::PoseStamped>(
          "world/place",
          [this](const auto& message) { Log(world_.PutDown(FromMessage(message.pose))); }),
      On<msg::String>("world/fault", [this](const auto& message) { SetFault(message.data); }),
      On<msg::Float32>("world/speed", [this](const auto& message) { SetSpeed(message.data); }),
      On<msg::LedState>(
          "world/led",
          [this](const auto& message) { world_.SetLight(message.target, FromMessage(message)); },
          kLatchedFromManyQos),
      On<msg::Bool>(
          "world/motor_power", [this](const auto& message) { world_.SetMotorPower(message.data); },
          kLatchedQos),
      On<msg::MachineStatus>(
          "musher/machine_status",
          [this](const auto& message) { world_.SetMachineState(message.state); }, kLatchedQos),
  };
  for (const Result<>& result : results) {
    if (!result) return result;
  }
  return Ok();
}

Result<> WorldHost::Serve() {
  const std::array results = {
      Answer<msg::SetBool>("world/charge",
                           [this](const auto& request, auto reply) {
                             world_.Plug(request.data);
                             Log(std::string("the cable is ") + (request.data ? "in" : "out"));
                             reply({true, ""});
                           }),
      Answer<msg::SetBool>("world/pause",
                           [this](const auto& request, auto reply) {
                             pacer_.SetPaused(request.data, node_.loop().Now());
                             request.data ? next_step_.reset() : SetSpeed(pacer_.factor());
                             reply({true, ""});
                           }),
      Answer<msg::Trigger>("world/draw",
                           [this](const auto&, auto reply) {
                             DrawPicture(
                                 [reply = std::move(reply)](bool ok, const std::string& text) {
                                   reply({ok, text});
                                 });
                           }),
  };
  for (const Result<>& result : results) {
    if (!result) return result;
  }
  return Ok();
}

void WorldHost::Arm(Time when) {
  next_step_ = node_.loop().At(when, [this] { OnStep(); });
}

void WorldHost::OnStep() {
  if (cameras_->waits()) {
    late_ = true;
    return;
  }
  const StepOutputs outputs = world_.Step();
  static_cast<void>(clock_->Publish({msg::ToStamp(world_.now())}));  // the next one follows soon
  static_cast<void>(body_state_->Publish(ToBodyState(world_)));
  constexpr Duration kBatteryPeriod = std::chrono::seconds(1);
  if (world_.now() % kBatteryPeriod < kStep || world_.now() == kStep) {
    static_cast<void>(battery_->Publish(ToBatteryState(world_)));
  }
  sensors_->OnStep(world_);
  show_->OnStep();
  cameras_->OnStep(world_);
  for (const int touch : outputs.touches) Touch(touch);
  for (const std::string& line : outputs.log) Log(line);
  if (outputs.speed) return SetSpeed(*outputs.speed);
  Arm(pacer_.Next(node_.loop().Now()));
  Log(pacer_.TakeLogLine());
}

void WorldHost::Touch(int state) {
  if (state < 1 || state > kMostTouchState) {
    return Log("a touch of kind " + std::to_string(state) + " is refused: expected 1 to 17");
  }
  if (auto sent = touch_->Publish({state}); !sent) Log(sent.error().message);
}

void WorldHost::SetSpeed(double factor) {
  if (!(factor >= kLeastSpeed && factor <= kMostSpeed)) {
    return Log("that speed of time is refused: expected 0.01 to 100");
  }
  const Time now = node_.loop().Now();
  pacer_.SetFactor(factor, now);
  if (!pacer_.paused()) Arm(pacer_.due());
}

// "lifted", "motor 3", "camera front".
void WorldHost::SetFault(const std::string& text) {
  if (std::find(std::begin(kSensorFaults), std::end(kSensorFaults), text) !=
      std::end(kSensorFaults)) {
    world_.Silence(text);
    return Log("fault: " + text);
  }
  std::istringstream words(text);
  std::string name;
  std::size_t motor = 0;
  words >> name;
  const FaultKind* fault = FindFault(name);
  const bool has_motor = static_cast<bool>(words >> motor);
  std::string rest;
  const bool clean = has_motor ? words.eof() : words.eof() && text.size() == name.size();
  if (fault == nullptr || !clean || motor >= kMotors || (has_motor && !fault->of_a_motor)) {
    return Log("a fault \"" + text.substr(0, 60) + "\" is refused: unknown fault");
  }
  world_.SetFault(*fault, motor);
  Log("fault: " + text);
}

void WorldHost::DrawPicture(std::function<void(bool, const std::string&)> reply) {
  if (drawing_) return reply(false, "a picture is being drawn");
  drawing_ = true;
  auto finish = [this, alive = std::weak_ptr(alive_), reply = std::move(reply),
                 path = options_.picture_path](const Result<>& drawn) {
    if (alive.expired()) return;
    drawing_ = false;
    if (!drawn) Log(drawn.error().message);
    reply(drawn.ok(), drawn ? path : drawn.error().message);
  };
  options_.in_background([world = world_, path = options_.picture_path, loop = &node_.loop(),
                          finish = std::move(finish)] {
    loop->Post([finish, drawn = Draw(world, path)] { finish(drawn); });
  });
}

void WorldHost::Log(const std::optional<std::string>& line) const {
  if (line) options_.log(*line);
}

template <msg::Message M>
Result<> WorldHost::Make(std::unique_ptr<transport::Publisher<M>>& publisher,
                         const std::string& topic, const transport::Qos& qos) {
  auto made = transport::MakePublisher<M>(node_, Name(topic), qos);
  if (!made) return made.error();
  publisher = std::move(made).value();
  return Ok();
}

template <msg::Message M>
Result<> WorldHost::On(const std::string& topic, std::function<void(const M&)> handler,
                       const transport::Qos& qos) {
  auto made = transport::MakeSubscription<M>(
      node_, Name(topic),
      [handler = std::move(handler)](const M& message, const transport::SampleInfo&) {
        handler(message);
      },
      qos);
  if (!made) return made.error();
  endpoints_.push_back(std::move(made).value());
  return Ok();
}

template <msg::Service S>
Result<> WorldHost::Answer(const std::string& service,
                           typename transport::Server<S>::Handler handler) {
  auto made = transport::MakeServer<S>(node_, Name(service), std::move(handler));
  if (!made) return made.error();
  endpoints_.push_back(std::move(made).value());
  return Ok();
}

std::string WorldHost::Name(const std::string& name) const {
  return transport::ResolveName(options_.name_space, name);
}

}  // namespace musher::world
