#include "musher/modules/world/process/world_host.hpp"

#include <algorithm>
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
#include "musher/modules/world/simulation/referee_report.hpp"
#include "musher/transport/clock.hpp"
#include "musher/transport/clock_reached.hpp"

namespace musher::world {
namespace {

// Of real time, in lockstep: how long a step waits before /clock is repeated, and how often.
constexpr Duration kReminder = Milliseconds(100);
constexpr int kMostReminders = 9;

}  // namespace

using transport::kLatchedFromManyQos;
using transport::kLatchedQos;

WorldHost::WorldHost(transport::Node& node, Scene scene, HostOptions options)
    : node_(node),
      options_(std::move(options)),
      world_(std::move(scene)),
      pacer_(kStep, world_.scene().speed, node.loop().Now()),
      endpoints_(node, options_.name_space) {}

WorldHost::~WorldHost() = default;

Result<std::unique_ptr<WorldHost>> WorldHost::Start(transport::Node& node, Scene scene,
                                                    HostOptions options) {
  std::unique_ptr<WorldHost> host(new WorldHost(node, std::move(scene), std::move(options)));
  if (auto connected = host->Connect(); !connected) return connected.error();
  host->SetSpeed(host->world_.scene().speed);
  return host;
}

Result<> WorldHost::Connect() {
  Publish();
  if (Result<> made = MakeCameras(); !made) return made;
  if (world_.scene().lockstep) ListenToFollowers();
  if (world_.scene().has_body && world_.scene().motion_board.lcm) {
    auto board = WorldBoard::Open(node_.loop(), world_, options_.log);
    if (!board) return board.error();
    board_ = std::move(board).value();
  }
  Listen();
  Serve();
  return endpoints_.opened();
}

void WorldHost::Publish() {
  // In every namespace.
  clock_ = endpoints_.Advertise<msg::Clock>(std::string("/") + transport::kClockTopic,
                                            transport::kClockQos);
  if (world_.scene().has_body) {
    body_state_ = endpoints_.Advertise<msg::BodyState>("world/body_state");
    battery_ = endpoints_.Advertise<msg::BatteryState>("world/battery");
    sensors_ = std::make_unique<WorldSensors>(endpoints_, world_.scene());
  }
  touch_ = endpoints_.Advertise<msg::Int32>("world/touch");
  show_ = std::make_unique<WorldShow>(endpoints_, world_, options_.log);
  robots_ = std::make_unique<WorldRobots>(endpoints_, world_, options_.log);
  field_ = std::make_unique<WorldField>(endpoints_, world_, options_.log);
  frames_ = std::make_unique<WorldFrames>(endpoints_, world_, *robots_);
}

Result<> WorldHost::MakeCameras() {
  auto cameras = WorldCameras::Make(endpoints_, world_.scene(),
                                    {options_.log, options_.shooter, [this] { Continue(); }});
  if (!cameras) return cameras.error();
  cameras_ = std::move(cameras).value();
  return Ok();
}

void WorldHost::Listen() {
  if (!board_) {
    endpoints_.Subscribe<msg::MotionCustomCommand>(
        "world/body_command", [this](const auto& message) {
          const auto command = FromMessage(message);
          Log(command ? world_.Command(command.value())
                      : "a body command is refused: " + command.error().message);
        });
  }
  endpoints_.Subscribe<msg::Float32>(
      "world/set_battery", [this](const auto& message) { Log(world_.SetBattery(message.data)); });
  endpoints_.Subscribe<msg::Int32>("world/press",
                                   [this](const auto& message) { Touch(message.data); });
  endpoints_.Subscribe<msg::PoseStamped>("world/place", [this](const auto& message) {
    Log(world_.PutDown(FromMessage(message.pose)));
  });
  endpoints_.Subscribe<msg::String>("world/fault",
                                    [this](const auto& message) { SetFault(message.data); });
  for (const bool shown : {true, false}) {
    endpoints_.Subscribe<msg::String>(
        shown ? "world/show" : "world/hide",
        [this, shown](const auto& message) { Log(world_.SetShown(message.data, shown)); });
  }
  endpoints_.Subscribe<msg::String>("world/mark",
                                    [this](const auto& message) { world_.AddMark(message.data); });
  endpoints_.Subscribe<msg::Float32>("world/speed",
                                     [this](const auto& message) { SetSpeed(message.data); });
  endpoints_.Subscribe<msg::LedState>(
      "world/led",
      [this](const auto& message) { world_.SetLight(message.target, FromMessage(message)); },
      kLatchedFromManyQos);
  endpoints_.Subscribe<msg::Bool>(
      "world/motor_power", [this](const auto& message) { world_.SetMotorPower(message.data); },
      kLatchedQos);
  endpoints_.Subscribe<msg::MachineStatus>(
      "musher/machine_status",
      [this](const auto& message) { world_.SetMachineState(message.state); }, kLatchedQos);
}

void WorldHost::Serve() {
  endpoints_.Serve<msg::SetBool>("world/charge", [this](const auto& request, auto reply) {
    world_.Plug(request.data);
    Log(std::string("the cable is ") + (request.data ? "in" : "out"));
    reply({true, ""});
  });
  endpoints_.Serve<msg::SetBool>("world/pause", [this](const auto& request, auto reply) {
    pacer_.SetPaused(request.data, node_.loop().Now());
    request.data ? next_step_.reset() : SetSpeed(pacer_.factor());
    reply({true, ""});
  });
  endpoints_.Serve<msg::Trigger>("world/referee", [this](const auto&, auto reply) {
    reply({true, RefereeText(world_.scene(), world_.referee(), world_.now())});
  });
  endpoints_.Serve<msg::Trigger>("world/referee_json", [this](const auto&, auto reply) {
    reply({true, RefereeJson(world_.scene(), world_.referee(), world_.now())});
  });
  endpoints_.Serve<msg::Trigger>("world/draw", [this](const auto&, auto reply) {
    DrawPicture([reply = std::move(reply)](bool ok, const std::string& text) {
      reply({ok, text});
    });
  });
}

void WorldHost::Arm(Time when) {
  next_step_ = node_.loop().At(when, [this] { OnStep(); });
}

bool WorldHost::Waits() const {
  return cameras_->waits() || !followers_.Reached(world_.now());
}

void WorldHost::Continue() {
  if (Waits() || !std::exchange(late_, false) || pacer_.paused()) return;
  reminder_.reset();
  OnStep();
}

void WorldHost::ListenToFollowers() {
  endpoints_.SubscribeEach<msg::Clock>(
      std::string("/") + transport::kClockReachedTopic,
      [this](const auto& reached, transport::EndpointId follower) {
        followers_.OnReached(follower, msg::FromStamp(reached.clock));
        Continue();
      },
      [this](transport::EndpointId follower) {
        followers_.OnLost(follower);
        Continue();
      },
      transport::kClockReachedQos);
}

// A sample of /clock may be lost, and a process may hang or be gone.
void WorldHost::Remind(int reminders) {
  reminder_ = node_.loop().At(node_.loop().Now() + kReminder, [this, reminders] {
    if (followers_.Reached(world_.now())) return;  // time waits for a picture
    if (reminders < kMostReminders) {
      static_cast<void>(clock_->Publish({msg::ToStamp(world_.now())}));
      return Remind(reminders + 1);
    }
    const int lost = followers_.GiveUp(world_.now());
    Log("time no longer waits for " + std::to_string(lost) + " of the processes that use /clock, " +
        "which have not handled it for " +
        std::to_string(ToMilliseconds(kReminder * (kMostReminders + 1))) + " ms");
    Continue();
  });
}

void WorldHost::OnStep() {
  if (Waits()) {
    late_ = true;
    return Remind(0);
  }
  const StepOutputs outputs = world_.Step();
  static_cast<void>(clock_->Publish({msg::ToStamp(world_.now())}));  // the next one follows soon
  if (world_.scene().has_body) PublishBody();
  robots_->OnStep();
  field_->OnStep();
  frames_->OnStep();
  show_->OnStep();
  cameras_->OnStep(world_);
  for (const int touch : outputs.touches) Touch(touch);
  for (const std::string& line : outputs.log) Log(line);
  if (outputs.speed) return SetSpeed(*outputs.speed);
  Arm(pacer_.Next(node_.loop().Now()));
  Log(pacer_.TakeLogLine());
}

void WorldHost::PublishBody() {
  static_cast<void>(body_state_->Publish(ToBodyState(world_)));
  constexpr Duration kBatteryPeriod = std::chrono::seconds(1);
  if (world_.now() % kBatteryPeriod < kStep || world_.now() == kStep) {
    static_cast<void>(battery_->Publish(ToBatteryState(world_)));
  }
  if (board_) board_->OnStep();
  sensors_->OnStep(world_);
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
  const auto is_of = [&](const auto& faults) {
    return std::find(std::begin(faults), std::end(faults), text) != std::end(faults);
  };
  if (is_of(kSensorFaults) || (world_.field() && is_of(kFieldFaults))) {
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

}  // namespace musher::world
