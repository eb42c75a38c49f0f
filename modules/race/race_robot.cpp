#include "musher/modules/race/race_robot.hpp"

#include <limits>
#include <utility>

#include "musher/actuator/program/await.hpp"
#include "musher/base/joined.hpp"
#include "musher/messages/protocol/device.hpp"
#include "musher/messages/stamp.hpp"
#include "musher/messages/yaw.hpp"
#include "musher/modules/race/charger_reports.hpp"
#include "musher/modules/race/topic_names.hpp"

namespace musher::race {
namespace {

constexpr double kRateHz = 20;  // of servo frames, within the motion manager's watchdog of 200 ms
constexpr Duration kInfoPeriod = Milliseconds(100);
constexpr Duration kHeartbeatPeriod = Milliseconds(500);
// Of the steady clock, where a reply is lost; the course's limits are of the machine's clock.
constexpr Duration kLongestCall = std::chrono::minutes(5);
constexpr const char* kModuleName = "race";
constexpr const char* kTwoBatteries =
    "two publishers of bms_status are received in turn: the robot counts as on a charger while one "
    "of them reports it; end one of them, or give each robot its namespace";

FsmActuator::Options OptionsOf(const Course& course) {
  FsmActuator::Options options;
  options.rate_hz = kRateHz;
  options.ends_after_break = false;  // a race waits for START after a shorter one
  options.resume =
      course.robot.from_start ? FsmActuator::Resume::kFromStart : FsmActuator::Resume::kWhereItWas;
  return options;
}

}  // namespace

RaceRobot::RaceRobot(const std::string& actuator_name, Course course)
    : FsmActuator(actuator_name, OptionsOf(course)), race_(std::move(course), *this) {}

RaceRobot::~RaceRobot() = default;

Result<> RaceRobot::BuildMachine(fsm::Machine& machine) {
  if (Result<> built = race_.Build(machine); !built) return built;
  return race_.course().robot.record.empty() ? Ok() : Record(machine);
}

Result<> RaceRobot::Record(fsm::Machine& machine) {
  auto recording = FsmRecording::Open(machine, race_.course().robot.record, "robot.record",
                                      [this](const std::string& line) { Log(line); });
  if (!recording) return recording.error();
  recording_ = std::move(recording).value();
  race_.RecordTo(recording_->recorder());
  return Ok();
}

void RaceRobot::OpenTopics(transport::Endpoints& topics) {
  const auto wire = std::make_shared<Wire>(topics.node().loop());
  wire->info = topics.Advertise<msg::String>(topic::kInfo);
  wire->servo = topics.Advertise<msg::MotionServoCmd>(topic::kServo);
  wire->motion = topics.OpenClient<msg::MotionResultCmd>(topic::kMotion);
  wire->speech = topics.OpenClient<msg::AudioTextPlay>(topic::kSpeech);
  OpenWalkers(topics, *wire);
  Subscribe(topics);
  if (!topics.opened()) return;  // SetUp fails with it
  wire->detectors = std::make_unique<Detectors>(topics.node(), machine_config().name_space,
                                                race_.course(), DetectorHandlers());
  wire_ = wire;
  topics.Keep(wire);
  topics.Every(kInfoPeriod, [this] {
    CheckBreak();  // also in a pause
    race_.PassTime(Now());
    const auto open = wire_.lock();
    if (open) static_cast<void>(open->info->Publish({race_.InfoText()}));
  });
}

void RaceRobot::OpenWalkers(transport::Endpoints& topics, Wire& wire) {
  const std::vector<LaneWalk>& walks = race_.course().walks;
  for (Index i = 0; i < walks.size(); ++i) {
    wire.walkers.push_back(topics.Advertise<msg::String>(walks[i].command));
    wire.walker_statuses.push_back(topics.Subscribe<msg::String>(
        walks[i].status,
        [this, i](const auto& status) { race_.OnWalkerStatus(i, status.data, Now()); }));
  }
}

// The reports of another robot's body would hide that this one has fallen.
template <msg::Message M>
void RaceRobot::SubscribeToBody(transport::Endpoints& topics, const std::string& topic,
                                std::function<void(const M&)> handler, const transport::Qos& qos) {
  topics.SubscribeEach<M>(
      topic,
      [this, topic, handler = std::move(handler), publishers = transport::PublisherTurns()](
          const M& sample, transport::EndpointId publisher) mutable {
        if (publishers.Note(publisher)) race_.OnTwoPublishers(topic, Now());
        handler(sample);
      },
      [](transport::EndpointId) {}, qos);
}

void RaceRobot::SubscribeToBattery(transport::Endpoints& topics) {
  topics.SubscribeEach<msg::BmsStatus>(
      topic::kBattery,
      [this, &loop = topics.node().loop(), reports = ChargerReports()](
          const msg::BmsStatus& battery, transport::EndpointId publisher) mutable {
        // Full, hot, or at its threshold it is on the charger, and does not charge.
        const bool on = battery.power_wired_charging || battery.power_wp_place ||
                        battery.power_wp_charging || battery.power_expower_supply;
        const ChargerReports::Change change = reports.Take(publisher, on, loop.Now());
        if (change.doubled) FsmActuator::Log(LogLevel::kWarning, kTwoBatteries);
        if (change.on) race_.OnCharger(*change.on, Now());
      },
      [](transport::EndpointId) {}, transport::kSensorDataQos);
}

void RaceRobot::Subscribe(transport::Endpoints& topics) {
  topics.Subscribe<msg::String>(topic::kCommand, [this](const auto& text) {
    race_.OnCommand(text.data, Now(), CheckNotLate());
  });
  SubscribeToBody<msg::MotionStatus>(topics, topic::kBody, [this](const auto& body) {
    race_.OnBody(body.switch_status, body.motion_id, Now());
  });
  SubscribeToBody<msg::MotionServoResponse>(topics, topic::kServoReply, [this](const auto& reply) {
    race_.OnServoReply(reply.result, reply.code, Now());
  });
  SubscribeToBattery(topics);
  const OdometryRules& odometry = race_.course().odometry;
  if (!odometry.used()) return;
  SubscribeToBody<msg::Odometry>(
      topics, odometry.topic, [this](const msg::Odometry& sample) { OnOdometry(sample); },
      transport::kSensorDataQos);
}

void RaceRobot::OnOdometry(const msg::Odometry& sample) {
  const msg::Pose& pose = sample.pose.pose;
  const msg::Quaternion& turn = pose.orientation;
  const double norm = turn.x * turn.x + turn.y * turn.y + turn.z * turn.z + turn.w * turn.w;
  const bool is_turn = norm > 0.5 && norm < 2;  // NaN is none, which the race refuses
  const double yaw_rad = is_turn ? msg::YawOf(turn) : std::numeric_limits<double>::quiet_NaN();
  race_.OnOdometry(msg::FromStamp(sample.header.stamp).count(),
                   {{pose.position.x, pose.position.y}, yaw_rad}, TakenAt(sample.header.stamp),
                   Now());
}

Detectors::Handlers RaceRobot::DetectorHandlers() {
  return {.on_sighting =
              [this](Index detector, const msg::Sighting& found) {
                race_.OnSighting(detector,
                                 {found.seen, found.distance_m, found.phase, found.text,
                                  found.x + found.width / 2 - 0.5, found.confidence},
                                 TakenAt(found.header.stamp), Now());
              },
          .on_lines =
              [this](Index detector, const msg::YellowLines& lines) {
                race_.OnLines(detector, lines.contours, lines.ycy, lines.dy, lines.middle_offset,
                              TakenAt(lines.header.stamp), Now(), lines.doubt);
              },
          .on_text = [this](Index detector,
                            const std::string& text) { race_.OnText(detector, text, Now()); },
          .on_doubt = [this](Index detector,
                             const std::string& why) { race_.OnDoubt(detector, why, Now()); },
          .on_two_publishers =
              [this](Index detector) {
                race_.OnTwoPublishers(race_.course().detectors[detector].topic, Now());
              },
          .log = [this](const std::string& line) { Log(line); }};
}

Time RaceRobot::TakenAt(const msg::Stamp& stamp) const {
  if (stamp == msg::Stamp{}) return Now();  // a publisher without a clock
  return Now() - (msg::FromStamp(Stamp()) - msg::FromStamp(stamp));
}

// Programs that were started just now may not have been discovered yet. The detectors are opened
// for it, and closed again.
Result<> RaceRobot::SelfCheck() {
  const RobotRules& rules = race_.course().robot;
  CheckVerdict verdict;
  const auto open_all = [this](bool open) {
    RunOnLoop([this, open] {
      if (const auto wire = wire_.lock()) wire->detectors->OpenAll(open);
    });
  };
  if (!node()) return Ok();
  if (rules.cameras != Need::kNone) open_all(true);
  const auto look = [&]() -> Result<> {
    verdict = EvaluateSelfCheck(Look(), rules);
    if (!verdict.result || verdict.missing.empty()) return verdict.result;
    return Error{kCodeFailed, verdict.missing};
  };
  static_cast<void>(
      program::AwaitOnLoop(*node(), rules.self_check, look, [this] { return StopRequested(); }));
  open_all(false);
  if (!verdict.missing.empty()) Log("self-check: without " + verdict.missing);
  return verdict.result;
}

MissingParts RaceRobot::Look() {
  const auto wire = wire_.lock();
  if (!wire) return {};
  MissingParts found;
  if (!wire->motion->Ready()) found.motion = "no service " + std::string(topic::kMotion);
  if (!wire->speech->Ready()) found.audio = "no service " + std::string(topic::kSpeech);
  if (const auto missing = wire->detectors->Missing(); !missing.empty()) {
    found.cameras = "no publisher of " + Joined(missing);
  }
  if (const auto doubled = wire->detectors->Doubled(); !doubled.empty()) {
    found.cameras += (found.cameras.empty() ? "" : ", ") +
                     std::string("more than one publisher of ") + Joined(doubled);
  }
  std::vector<std::string> walkers;
  for (Index i = 0; i < wire->walker_statuses.size(); ++i) {
    if (wire->walker_statuses[i]->MatchedWriters() > 0) continue;
    walkers.push_back(race_.course().walks[i].status);
  }
  if (!walkers.empty()) found.walker = "no publisher of " + Joined(walkers);
  return found;
}

void RaceRobot::Walk(const ServoFrame& frame) {
  const auto wire = wire_.lock();
  if (!wire) return;
  msg::MotionServoCmd command;
  command.motion_id = frame.motion_id;
  command.cmd_type = frame.end ? msg::MotionServoCmd::kEnd : msg::MotionServoCmd::kData;
  command.cmd_source = msg::MotionSource::kAlgo;
  command.vel_des = {static_cast<float>(frame.twist.forward_m_s),
                     static_cast<float>(frame.twist.left_m_s),
                     static_cast<float>(frame.twist.yaw_rad_s)};
  for (auto* three : {&command.rpy_des, &command.pos_des, &command.ctrl_point}) *three = {0, 0, 0};
  for (auto* six : {&command.acc_des, &command.foot_pose}) six->assign(6, 0);
  command.step_height = {static_cast<float>(frame.step_height_m[0]),
                         static_cast<float>(frame.step_height_m[1])};
  static_cast<void>(wire->servo->Publish(command));
}

void RaceRobot::Move(std::int32_t motion_id, std::uint64_t number) {
  const auto wire = wire_.lock();
  if (!wire) return;
  msg::MotionResultCmd::Request request;
  request.motion_id = motion_id;
  request.cmd_source = msg::MotionSource::kAlgo;
  wire->motion->Call(request, kLongestCall, [this, number](const auto& answer) {
    if (!answer) return race_.OnMotionDone(number, answer.error(), Now());
    const auto& reply = answer.value();
    const bool done = reply.result && reply.code == kCodeOk;
    const std::int32_t code = reply.code == kCodeOk ? kCodeFailed : reply.code;
    race_.OnMotionDone(
        number,
        done ? Result<>() : Error{code, "the body is in motion " + std::to_string(reply.motion_id)},
        Now());
  });
}

void RaceRobot::CommandWalker(const LaneWalk& walk, bool start) {
  const auto wire = wire_.lock();
  const auto index = FindByName(race_.course().walks, walk.name);
  if (!wire || !index) return;
  static_cast<void>(wire->walkers[*index]->Publish({start ? "START" : "STOP"}));
  if (start) {
    lane_walk_ = index;
    heartbeat_at_ = Now();
  } else if (lane_walk_ == index) {
    lane_walk_.reset();
  }
}

void RaceRobot::CheckBreak() {
  const auto wire = wire_.lock();
  if (!wire) return;
  if (const auto length = wire->breaks.Take()) race_.OnBreak(*length, Now());
}

void RaceRobot::AfterTick(Time now) {
  race_.AfterTick();
  if (!lane_walk_ || now - heartbeat_at_ < kHeartbeatPeriod) return;
  heartbeat_at_ = now;
  if (const auto wire = wire_.lock()) {
    static_cast<void>(wire->walkers[*lane_walk_]->Publish({"HEARTBEAT"}));
  }
}

void RaceRobot::Watch(const std::vector<bool>& detectors) {
  if (const auto wire = wire_.lock()) wire->detectors->Watch(detectors);
}

void RaceRobot::Speak(const std::string& text, std::uint64_t number) {
  const auto wire = wire_.lock();
  if (!wire) return;
  msg::AudioTextPlay::Request request;
  request.module_name = kModuleName;
  request.is_online = true;
  request.text = text;
  wire->speech->Call(request, kLongestCall, [this, number](const auto& answer) {
    if (!answer) return race_.OnSpoken(number, answer.error(), Now());
    const auto& reply = answer.value();
    const bool spoken = reply.status == msg::AudioTextPlay::kFinished;
    race_.OnSpoken(number,
                   spoken ? Result<>()
                          : Error{reply.code == kCodeOk ? kCodeFailed : reply.code,
                                  "the audio manager has not spoken it"},
                   Now());
  });
}

void RaceRobot::ShowState(int number) {
  const auto wire = wire_.lock();
  if (wire) static_cast<void>(wire->info->Publish({"State:" + std::to_string(number)}));
}

}  // namespace musher::race
