#include "musher/modules/wedding/wedding_robot.hpp"

#include <chrono>
#include <utility>

#include "musher/actuator/program/await.hpp"
#include "musher/messages/std_msgs/basic.hpp"
#include "musher/messages/std_srvs/set_bool.hpp"
#include "musher/messages/std_srvs/trigger.hpp"
#include "musher/modules/wedding/topic_names.hpp"

namespace musher::wedding {
namespace {

constexpr Duration kVisionSilence =
    Milliseconds(2000);  // without a message for longer, in Active, the check fails

FsmActuator::Options OptionsOf(const WeddingConfig& config) {
  FsmActuator::Options options;
  options.rate_hz = config.rate_hz;
  options.begin = config.autostart ? Begin::kAtActive : Begin::kOnCommand;
  options.resume = FsmActuator::Resume::kWhereItWas;  // in IDLE, where Pause() left it
  return options;
}

Duration ToDuration(const msg::Stamp& stamp) {
  return std::chrono::seconds(stamp.sec) + std::chrono::nanoseconds(stamp.nanosec);
}

// "no publisher of" and the like; empty when there is one.
std::string Missing(int matched, const char* what, const char* name) {
  return matched > 0 ? "" : std::string(what) + " " + name;
}

}  // namespace

WeddingRobot::WeddingRobot(const std::string& actuator_name, WeddingConfig config)
    : FsmActuator(actuator_name, OptionsOf(config)),
      config_(std::move(config)),
      show_(config_.show, *this) {}

WeddingRobot::~WeddingRobot() = default;

Result<> WeddingRobot::BuildMachine(fsm::Machine& machine) {
  if (Result<> built = show_.Build(machine); !built) return built;
  return config_.record.empty() ? Ok() : Record(machine);
}

Result<> WeddingRobot::Record(fsm::Machine& machine) {
  auto recording = FsmRecording::Open(machine, config_.record, "record.file",
                                      [this](const std::string& line) { Log(line); });
  if (!recording) return recording.error();
  recording_ = std::move(recording).value();
  show_.RecordTo(recording_->recorder());
  return Ok();
}

void WeddingRobot::OpenTopics(transport::Endpoints& topics) {
  const auto wire = std::make_shared<Wire>();
  wire->state = topics.Advertise<msg::String>(topic::kState);
  wire->pose = topics.Advertise<msg::String>(topic::kPose);
  wire->look_at = topics.Advertise<msg::PointStamped>(topic::kLookAt);
  wire->play = topics.Advertise<msg::String>(topic::kPlay);
  auto* camera = config_.camera_service.empty()
                     ? nullptr
                     : topics.OpenClient<msg::CameraService>(config_.camera_service);
  if (camera != nullptr) {
    wire->photographer.emplace(*camera, config_.photo_timeout,
                               [this](const std::string& line) { Log(line); });
  }
  if (config_.second_generation) {
    wire->second.emplace().Open(topics, show_, [this] { return Now(); });
  }
  Subscribe(topics, *wire);
  SubscribeJoints(topics);
  Serve(topics);
  if (!topics.opened()) return;  // SetUp fails with it
  wire_ = wire;
  topics.Keep(wire);
  const std::chrono::duration<double> period(1 / config_.state_rate_hz);
  topics.Every(std::chrono::duration_cast<Duration>(period), [this] {
    ShowState(show_.state());
    ShowFace();
    show_.PassTime(Now());
  });
}

void WeddingRobot::Subscribe(transport::Endpoints& topics, Wire& wire) {
  wire.target = topics.Subscribe<msg::PointStamped>(topic::kTarget, [this](const auto& target) {
    seen_at_ = Now();
    show_.OnTarget(
        {{target.point.x, target.point.y}, target.point.z, ToDuration(target.header.stamp)}, Now());
  });
  constexpr transport::Qos kNewest{transport::Qos::Reliability::kBestEffort,
                                   transport::Qos::Durability::kVolatile, 1};
  topics.Subscribe<msg::String>(
      topic::kFaces,
      [this](const auto& faces) {
        seen_at_ = Now();
        show_.OnFaces(faces.data, Now());
      },
      kNewest);
  topics.Subscribe<msg::String>(topic::kGesture,
                                [this](const auto& word) { show_.OnGesture(word.data, Now()); });
  topics.SubscribeEach<msg::Bool>(
      topic::kTooClose,
      [this](const auto& close, transport::EndpointId publisher) {
        show_.OnTooClose(close.data, Now(), PublisherId(publisher.value()));
      },
      [this](transport::EndpointId publisher) {
        show_.OnTooClosePublisherLost(PublisherId(publisher.value()), Now());
      });
  topics.Subscribe<msg::String>(topic::kCommand, [this](const auto& word) {
    show_.OnCommand(word.data, Now(), CheckNotLate());
  });
  topics.Subscribe<msg::String>(topic::kVoiceCommand, [this](const auto& word) {
    show_.OnVoiceCommand(word.data, Now(), CheckNotLate());
  });
  topics.Subscribe<msg::Float32>(
      topic::kVoiceLevel, [this](const auto& level) { show_.OnVoiceLevel(level.data, Now()); });
}

// Best effort, so that both kinds of publishers match.
void WeddingRobot::SubscribeJoints(transport::Endpoints& topics) {
  topics.Subscribe<msg::JointState>(
      topic::kJointStates,
      [this](const auto& joints) {
        show_.OnJointStates(joints.name, joints.position, ToDuration(joints.header.stamp), Now());
      },
      transport::kSensorDataQos);
  topics.Subscribe<msg::JointState>(
      topic::kJointCommands,
      [this](const auto& joints) { show_.OnJointCommands(joints.name, joints.position, Now()); },
      transport::kSensorDataQos);
}

void WeddingRobot::Serve(transport::Endpoints& topics) {
  topics.Serve<msg::Trigger>(topic::kReset, [this](const auto&, const auto& reply) {
    const Result<> done = show_.Reset(Now());
    reply({done.ok(), done ? "FSM reset to IDLE" : done.error().message});
  });
  topics.Serve<msg::SetBool>(topic::kSetIdle, [this](const auto&, const auto& reply) {
    const Result<> done = show_.Force(state::kIdle, Now());
    reply({done.ok(), done ? "Set to IDLE" : done.error().message});
  });
  topics.Serve<msg::Trigger>(topic::kStop, [this](const auto&, const auto& reply) {
    if (show_.resting()) return reply({false, "the show is paused: there is nothing to stop"});
    show_.OnCommand(command::kStop, Now());
    reply({true, "FSM stop command sent"});
  });
}

// Programs that were started just now may not have been discovered yet.
Result<> WeddingRobot::SelfCheck() {
  CheckVerdict verdict;
  const auto look = [&]() -> Result<> {
    verdict = EvaluateSelfCheck(Look(), config_);
    if (!verdict.result || verdict.missing.empty()) return verdict.result;
    return Error{kCodeFailed, verdict.missing};
  };
  static_cast<void>(program::AwaitOnLoop(*node(), config_.self_check_time, look,
                                         [this] { return StopRequested(); }));
  if (!verdict.missing.empty()) Log("self-check: without " + verdict.missing);
  return verdict.result;
}

MissingParts WeddingRobot::Look() {
  const auto wire = wire_.lock();
  if (!wire) return {};
  MissingParts found;
  found.camera = Missing(wire->target->MatchedWriters(), "no publisher of", topic::kTarget);
  if (found.camera.empty() && ticking() && (!seen_at_ || Now() - *seen_at_ > kVisionSilence)) {
    found.camera = "no message on " + std::string(topic::kTarget) + " and faces_json for 2 s";
  }
  found.audio = Missing(wire->play->MatchedReaders(), "no subscriber of", topic::kPlay);
  found.motion = Missing(wire->pose->MatchedReaders(), "no subscriber of", topic::kPose);
  if (wire->second && !wire->second->ready()) {
    found.ready = std::string(topic::kReady) + " is not true";
  }
  return found;
}

void WeddingRobot::TakePose(std::string_view pose) {
  if (const auto wire = wire_.lock()) {
    static_cast<void>(wire->pose->Publish({std::string(pose)}));
    if (wire->second) wire->second->SetPose(pose);
  }
}

void WeddingRobot::LookAt(Gaze gaze) {
  const auto wire = wire_.lock();
  if (!wire) return;
  msg::PointStamped look;
  look.header = {Stamp(), "camera"};
  look.point = {gaze.x, gaze.y, 0};
  static_cast<void>(wire->look_at->Publish(look));
}

void WeddingRobot::Play(std::string_view sound) {
  if (const auto wire = wire_.lock()) {
    static_cast<void>(wire->play->Publish({std::string(sound)}));
  }
}

void WeddingRobot::TakePhoto() {
  const auto wire = wire_.lock();
  if (wire && wire->photographer) wire->photographer->TakePhoto();
}

void WeddingRobot::RecordVideo(bool on) {
  const auto wire = wire_.lock();
  if (wire && wire->photographer) wire->photographer->RecordVideo(on);
}

void WeddingRobot::SetMotion(std::string_view motion) {
  const auto wire = wire_.lock();
  if (wire && wire->second) wire->second->SetMotion(motion);
}

void WeddingRobot::ShowFace() {
  const auto wire = wire_.lock();
  const PerceptionData& seen = show_.data().perception;
  if (wire && wire->second) wire->second->PublishFace(seen.face_detected ? seen.face_id : -1);
}

void WeddingRobot::Log(const std::string& line) {
  FsmActuator::Log(line);
  const auto wire = wire_.lock();
  if (wire && wire->second) wire->second->PublishLine(show_.state(), line);
}

void WeddingRobot::ShowState(std::string_view state) {
  if (const auto wire = wire_.lock()) {
    static_cast<void>(wire->state->Publish({std::string(state)}));
  }
}

}  // namespace musher::wedding
