#include "musher/modules/motion/motion_shell.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "musher/base/toml/file.hpp"
#include "musher/modules/motion/motion_wire.hpp"

namespace musher::motion {
namespace {

constexpr Duration kStatusPeriod = Milliseconds(100);
constexpr double kLeastStepM = 0.05;
constexpr double kJumpM = 1;
// Of a break in which this process could not run: callers of a motion give up early.
constexpr Duration kShortestBreak = Milliseconds(2000);
constexpr Duration kKnownWithin = kShortestBreak;  // the process of a caller

// As tf2 has it.
constexpr transport::Qos kTfQos{transport::Qos::Reliability::kReliable,
                                transport::Qos::Durability::kVolatile, 100};

// Of `begin`.sections.toml and `begin`.steps.toml. From any thread.
Result<UserGait> ReadGaitFiles(const std::string& begin) {
  std::array<std::string, 2> texts;
  for (std::size_t i = 0; i < texts.size(); ++i) {
    const std::string file = begin + (i == 0 ? ".sections.toml" : ".steps.toml");
    auto text = config_toml::ReadModuleText(file);
    if (!text) return Error{MotionCode(KeyCode::kUnSupport), file + ": " + text.error().message};
    texts[i] = std::move(text).value();
  }
  return ReadUserGait(texts[0], texts[1]);
}

bool HasStop(const MotionRequests& requests) {
  return std::ranges::count(requests, kEmergencyStop, &MotionRequest::id) > 0;
}
bool HasStop(const Result<MotionRequests>& requests) {
  return requests && HasStop(requests.value());
}

bool IsStop(const MotionEvent& event) {
  const auto* play = std::get_if<motion_event::PlayArrived>(&event);
  if (play != nullptr) return HasStop(play->requests);
  return std::holds_alternative<motion_event::EmergencyStop>(event);
}

}  // namespace

Result<std::unique_ptr<MotionShell>> MotionShell::Make(Dependencies dependencies,
                                                       const MakeBackend& make_backend) {
  std::unique_ptr<MotionShell> shell(new MotionShell(std::move(dependencies)));
  if (auto opened = shell->Open(make_backend); !opened) return opened.error();
  return shell;
}

MotionShell::MotionShell(Dependencies dependencies)
    : dependencies_(std::move(dependencies)),
      breaks_(dependencies_.node.loop(), kShortestBreak),
      endpoints_(dependencies_.node, dependencies_.name_space) {}

Result<> MotionShell::Open(const MakeBackend& make_backend) {
  if (!dependencies_.with_keys) {
    auto others = transport::OtherMachines::Make(dependencies_.node, dependencies_.name_space);
    if (!others) return others.error();
    other_machines_ = std::move(others).value();
  }
  OpenTopics();
  OpenFrames();
  if (!endpoints_.opened()) return endpoints_.opened();
  auto backend = make_backend([this](const BodyState& body) { OnBody(body); });
  if (!backend) return backend.error();
  backend_ = std::move(backend).value();
  OpenServices();
  if (!endpoints_.opened()) return endpoints_.opened();
  status_timer_ = dependencies_.clock.Every(kStatusPeriod, [this] { PublishStatus(); });
  return Ok();
}

void MotionShell::OpenTopics() {
  servo_responses_ = endpoints_.Advertise<msg::MotionServoResponse>("motion_servo_response");
  status_ = endpoints_.Advertise<msg::MotionStatus>("motion_status");
  odometry_ = endpoints_.Advertise<msg::Odometry>("odom_out");
  imu_ = endpoints_.Advertise<msg::Imu>("imu");
  errors_ = endpoints_.Advertise<msg::NodeError>("node_errors");
  speech_ = endpoints_.Advertise<msg::AudioPlayExtend>("speech_play_extend");
  endpoints_.SubscribeWithInfo<msg::MotionServoCmd>(
      "motion_servo_cmd",
      [this](const msg::MotionServoCmd& command, const transport::SampleInfo& info) {
        if (command.motion_id != kEmergencyStop && IsForAnother(info.participant)) return;
        Do(motion_event::ServoArrived{FromWire(command), breaks_.Recent()});
      },
      {}, transport::kSystemDefaultQos);
}

// A localisation or a world may publish the same frames: then the config leaves them out.
void MotionShell::OpenFrames() {
  const TfConfig& config = dependencies_.config.tf;
  if (config.publish) tf_ = endpoints_.Advertise<msg::TfMessage>("/tf", kTfQos);
  const msg::TfMessage fixed{FixedFrames(config)};
  if (fixed.transforms.empty()) return;
  auto* frames = endpoints_.Advertise<msg::TfMessage>("/tf_static", transport::kLatchedQos);
  // A latched sample that cannot be sent is the same fault as a topic that cannot be opened.
  if (frames != nullptr) static_cast<void>(frames->Publish(fixed));
}

void MotionShell::OpenServices() {
  using motion_action::Answer;
  endpoints_.Serve<msg::MotionResultCmd>(
      "motion_result_cmd",
      [this](const auto& request, const auto& reply, transport::ParticipantId caller) {
        const Result<MotionRequests> requests = MotionRequests{FromWire(request)};
        const OnAnswer on_answer = [reply](const Answer& answer) {
          reply({answer.motion_id, answer.code == kCodeOk, answer.code});
        };
        const std::int32_t source = request.cmd_source;
        TakeIfMeant(caller, source, requests, on_answer,
                    [this, source, requests, on_answer] { Play(source, requests, on_answer); });
      });
  endpoints_.Serve<msg::MotionCustomCmd>(
      "motion_custom_cmd",
      [this](const auto& request, const auto& reply, transport::ParticipantId caller) {
        const auto requests = RequestsOf(request);
        const OnAnswer on_answer = [id = request.motion_id, reply](const Answer& answer) {
          reply({id, answer.code == kCodeOk, answer.code});
        };
        const auto take = [this, request, requests, on_answer] {
          const bool defines = request.cmd_type == msg::MotionCustomCmd::kDefinition;
          if (defines && backend_->TakesGaits()) return DefineFromFiles(request, on_answer);
          Play(request.cmd_source, requests, on_answer);
        };
        TakeIfMeant(caller, request.cmd_source, requests, on_answer, take);
      });
  endpoints_.Serve<msg::MotionQueueCustomCmd>(
      "motion_queue_cmd",
      [this](const auto& request, const auto& reply, transport::ParticipantId caller) {
        const auto requests = RequestsOf(dependencies_.table, request);
        const OnAnswer on_answer = [reply](const Answer& answer) {
          reply({answer.code == kCodeOk, answer.code});
        };
        TakeIfMeant(caller, kFromApp, requests, on_answer,
                    [this, requests, on_answer] { Play(kFromApp, requests, on_answer); });
      });
  endpoints_.Serve<msg::MotionSequenceShow>(
      "motion_sequence_cmd",
      [this](const auto& request, const auto& reply, transport::ParticipantId caller) {
        const auto requests = RequestsOf(request);
        const OnAnswer on_answer = [id = request.motion_id, reply](const Answer& answer) {
          reply({answer.code == kCodeOk, answer.code, answer.message, id});
        };
        const auto take = [this, request, requests, on_answer] {
          const bool of_user = HasUserGait(request) && backend_->TakesGaits();
          if (of_user) return PlayUserGait(request, on_answer);
          Play(request.cmd_source, requests, on_answer);
        };
        TakeIfMeant(caller, request.cmd_source, requests, on_answer, take);
      });
  endpoints_.Serve<msg::MotorTemp>("motor_temp",
                                   [this](const auto&, auto reply) { reply(Temperatures()); });
}

void MotionShell::OnBody(const BodyState& body) {
  Do(motion_event::BoardReported{body.report, body.age});
  if (body.has_new_motion) {
    // No caller to report a failure to; the next one follows in 20 ms.
    MeasureWay(body.motion);
    const TfConfig& frames = dependencies_.config.tf;
    static_cast<void>(odometry_->Publish(OdometryOf(frames, body.motion, way_m_)));
    static_cast<void>(imu_->Publish(ImuOf(frames, body.motion)));
    if (tf_ != nullptr && tf_->MatchedReaders() > 0) {
      static_cast<void>(tf_->Publish({{BodyFrame(frames, body.motion)}}));
    }
  }
  for (const auto& then : std::exchange(next_report_callbacks_, {})) then();
}

// In steps: noise is no way. A jump is a new beginning: the board has restarted, or the world.
void MotionShell::MeasureWay(const BodyMotion& motion) {
  const Eigen::Vector2d at = motion.X_OB.translation().head<2>();
  const double step_m = position_ ? (at - *position_).norm() : kJumpM;
  if (step_m < kLeastStepM) return;
  way_m_ = step_m < kJumpM ? way_m_ + step_m : 0;
  position_ = at;
}

Result<> MotionShell::CheckFresh() {
  const auto could_not_run = breaks_.Recent();
  if (!could_not_run) return Ok();
  return Error{
      MotionCode(KeyCode::kTimeout),
      CouldNotRunText(*could_not_run) + ", and its caller may have given up; request it again"};
}

// While it is not known whose process has sent it, it may be another robot's.
bool MotionShell::IsForAnother(transport::ParticipantId caller) {
  if (!other_machines_) return false;
  const Time now = dependencies_.node.loop().Now();
  if (other_machines_->IsAwaited(caller)) {
    if (!unknown_since_ || now - unknown_last_ > kKnownWithin) unknown_since_ = now;
    unknown_last_ = now;
    if (now - *unknown_since_ > kKnownWithin) LogUnknown(caller);
    return true;
  }
  const MachineIdentity* other = other_machines_->Of(caller);
  if (other == nullptr) return false;
  if (!other_robot_logged_ || now - *other_robot_logged_ >= kLogPause) {
    other_robot_logged_ = now;
    dependencies_.log("motion commands of another machine, " + MachineText(*other) +
                      ", are ignored: it has the same namespace and domain; give each machine its "
                      "namespace");
  }
  return true;
}

// It is not obeyed: over a bad wifi another robot's frames may arrive long before its status.
void MotionShell::LogUnknown(transport::ParticipantId caller) {
  const Time now = dependencies_.node.loop().Now();
  if (unknown_logged_ && now - *unknown_logged_ < kLogPause) return;
  unknown_logged_ = now;
  const std::string name = transport::NameOf(dependencies_.node, caller);
  dependencies_.log("motion commands of " + (name.empty() ? "a program" : name) +
                    " are ignored: it has a publisher for the status of an actuator or controller, "
                    "and for 2 s none has arrived, so it may be another robot's; restart it if it "
                    "is of this one");
}

// No reply to another robot: its program takes the first one, which is that of its own manager.
void MotionShell::TakeIfMeant(transport::ParticipantId caller, std::int32_t source,
                              const Result<MotionRequests>& requests, const OnAnswer& on_answer,
                              std::function<void()> take) {
  if (!other_machines_ || HasStop(requests)) return take();
  const Time arrived = dependencies_.node.loop().Now();
  const auto once_known = [this, caller, source, on_answer, arrived, stops = stops_,
                           take = std::move(take)](bool known) {
    if (known && IsForAnother(caller)) return;
    const bool late = dependencies_.node.loop().Now() - arrived > kKnownWithin;
    if (!known || late) return LogUnknown(caller);
    const auto may = CheckNotStopped(stops);
    if (!may) return Play(source, may.error(), on_answer);
    take();
  };
  other_machines_->OnceKnown(caller, kKnownWithin, once_known);
}

// A command from before a stop must not end it, as recovery stand would.
Result<> MotionShell::CheckNotStopped(std::uint64_t stops) const {
  if (stops_ == stops) return Ok();
  return Error{MotionCode(MotionKey::kEstop),
               "the body was stopped after it was requested; request it again"};
}

void MotionShell::Play(std::int32_t source, const Result<MotionRequests>& requests,
                       OnAnswer on_answer) {
  if (!requests) {
    dependencies_.log("a command of " + SourceName(source) +
                      " is refused: " + requests.error().message + " (" +
                      std::to_string(requests.error().code) + ")");
    return on_answer({0, 0, requests.error().code, requests.error().message});
  }
  const auto fresh = HasStop(requests) ? Ok() : CheckFresh();
  if (const auto may = fresh ? CheckDefined(requests.value()) : fresh; !may) {
    return Play(source, may.error(), std::move(on_answer));
  }
  waiting_[++token_] = std::move(on_answer);
  Do(motion_event::PlayArrived{token_, source, requests.value()});
}

Result<> MotionShell::CheckDefined(const MotionRequests& requests) const {
  if (!backend_->TakesGaits()) return Ok();
  for (const auto& request : requests) {
    const Motion* motion = dependencies_.table.Find(request.id);
    if (motion == nullptr || !PlaysUserGait(*motion)) continue;
    const auto read = CheckRead(request.id, MotionCode(MotionKey::kSequenceDefinition));
    if (!read) return read;
    if (defined_ == request.id) continue;
    return Error{MotionCode(MotionKey::kSequenceDefinition), "the board has no gait of motion " +
                                                                 std::to_string(request.id) +
                                                                 ": its DEFINITION is first"};
  }
  return Ok();
}

// --- gaits of users ---

Result<> MotionShell::CheckRead(std::int32_t id, std::int32_t code) const {
  if (!reading_.contains(id)) return Ok();
  return Error{code, "the gait of motion " + std::to_string(id) +
                         " is being read from its files; request it again"};
}

// A gait is defined only where its motion could begin: a definition replaces the one in execution.
void MotionShell::Define(std::int32_t source, std::int32_t id, const Result<UserGait>& gait,
                         MotionBackend::OnDefined then) {
  const auto done = [this, source, id, then = std::move(then)](const Result<>& result) {
    if (!result) {
      dependencies_.log("the gait of motion " + std::to_string(id) + " of " + SourceName(source) +
                        " is refused: " + result.error().message + " (" +
                        std::to_string(result.error().code) + ")");
    }
    then(result);
  };
  if (!gait) return done(gait.error());
  if (const auto fresh = CheckFresh(); !fresh) return done(fresh.error());
  if (const auto fits = CheckGait(*dependencies_.table.Find(id), gait.value()); !fits) {
    return done(fits.error());
  }
  if (const auto may = MayPlay(Rules(), core_, {0, source, {{id, {}}}}); !may) {
    return done(may.error());
  }
  // Until the board has all of it, it may have half.
  defined_.reset();
  backend_->DefineGait(gait.value(), [this, id, done](const Result<>& result) {
    if (result) defined_ = id;
    done(result);
  });
}

// The files are read beside the loop: a board without frames lies down after half a second.
void MotionShell::DefineFromFiles(const msg::MotionCustomCmd::Request& request,
                                  OnAnswer on_answer) {
  const std::int32_t id = request.motion_id;
  const auto define = [this, source = request.cmd_source, id,
                       on_answer = std::move(on_answer)](const Result<UserGait>& gait) {
    Define(source, id, gait, [id, on_answer](const Result<>& defined) {
      on_answer(defined
                    ? motion_action::Answer{0, id, kCodeOk, ""}
                    : motion_action::Answer{0, id, defined.error().code, defined.error().message});
    });
  };
  const Motion* motion = dependencies_.table.Find(id);
  if (motion == nullptr || !PlaysUserGait(*motion)) {
    return define(
        Error{MotionCode(KeyCode::kUnSupport),
              "motion " + std::to_string(id) + " cannot be defined: it does not play gait 110"});
  }
  const auto read = CheckRead(id, MotionCode(KeyCode::kTargetBusy));
  if (!read) return define(read.error());
  reading_.insert(id);
  const Time asked = dependencies_.node.loop().Now();
  dependencies_.in_background([this, alive = std::weak_ptr<bool>(alive_), asked, id, define,
                               files = dependencies_.config.gaits + "/" + std::to_string(id)] {
    return [this, alive, asked, id, define, gait = ReadGaitFiles(files)] {
      if (alive.expired()) return;
      reading_.erase(id);
      const Duration took = dependencies_.node.loop().Now() - asked;
      if (took <= kShortestBreak) return define(gait);
      define(Error{MotionCode(KeyCode::kTimeout),
                   "its files were read in " + std::to_string(ToMilliseconds(took) / 1000) +
                       " s, and its caller may have given up; request it again"});
    };
  });
}

void MotionShell::PlayUserGait(const msg::MotionSequenceShow::Request& sequence,
                               OnAnswer on_answer) {
  const std::int32_t id = sequence.motion_id == 0 ? kUserSequence : sequence.motion_id;
  const std::int32_t source = sequence.cmd_source;
  Result<UserGait> gait = UserGaitOf(sequence);
  const Motion* motion = dependencies_.table.Find(id);
  if (motion == nullptr || !PlaysUserGait(*motion)) {
    gait = Error{MotionCode(KeyCode::kUnSupport),
                 "motion " + std::to_string(id) + " does not play the gait of a sequence"};
  }
  const auto read = CheckRead(id, MotionCode(KeyCode::kTargetBusy));
  if (gait && !read) gait = read.error();
  Define(source, id, gait,
         [this, source, id, stops = stops_,
          on_answer = std::move(on_answer)](const Result<>& defined) {
           if (!defined) return on_answer({0, id, defined.error().code, defined.error().message});
           const auto may = CheckNotStopped(stops);
           if (!may) return Play(source, may.error(), on_answer);
           Play(source, MotionRequests{{id, {}}}, on_answer);
         });
}

RequestToken MotionShell::LieDown(std::int32_t id, int tries, OnAnswer on_answer) {
  const RequestToken token = ++token_;
  waiting_[token] = std::move(on_answer);
  Do(motion_event::LieDown{token, id, tries});
  return token;
}

Result<> MotionShell::Check() const {
  const std::int32_t failed = MotionCode(KeyCode::kSelfCheckFailed);
  if (core_.BoardSilent()) {
    return Error{failed, "the motion board is silent: no report on " + backend_->Source()};
  }
  if (!core_.board_held.empty()) return Error{failed, core_.board_held};
  const auto& errors = core_.body->motor_error;
  const auto bad = std::find_if(errors.begin(), errors.end(), [](auto e) { return e != 0; });
  if (bad != errors.end()) {
    return Error{failed, MotorName(static_cast<std::size_t>(bad - errors.begin())) +
                             " reports: " + MotorFaultText(*bad)};
  }
  return Ok();
}

void MotionShell::PublishStatus() {
  static_cast<void>(status_->Publish(StatusOf(Rules(), core_)));
}

msg::MotorTemp::Response MotionShell::Temperatures() const {
  if (core_.BoardSilent()) {
    return {false, {}, MotionCode(MotionKey::kBoardSilent)};
  }
  const auto& temperatures = core_.body->motor_temperature;
  return {true, {temperatures.begin(), temperatures.end()}, kCodeOk};
}

void MotionShell::Do(const MotionEvent& event) {
  if (std::holds_alternative<motion_event::BoardRestarted>(event) ||
      std::holds_alternative<motion_event::OtherGait>(event)) {
    defined_.reset();
  }
  const auto is_frame = [](const MotionAction& action) {
    return std::holds_alternative<motion_action::Send>(action);
  };
  const bool was_stopped = core_.emergency_stop;
  MotionActions actions = Step(Rules(), core_, event, dependencies_.clock.Now());
  if (IsStop(event) || (core_.emergency_stop && !was_stopped)) ++stops_;
  // Frames first: a line of the log may wait for a disk, or for the reader of a pipe, and a stop
  // must not.
  std::stable_partition(actions.begin(), actions.end(), is_frame);
  for (const MotionAction& action : actions) Perform(action);
  Arm();
  std::string trouble = StopTrouble(Rules(), core_);
  if (trouble == stop_trouble_) return;
  stop_trouble_ = std::move(trouble);
  dependencies_.on_stop_trouble(stop_trouble_);
}

void MotionShell::Perform(const MotionAction& action) {
  if (const auto* send = std::get_if<motion_action::Send>(&action)) {
    backend_->Send(send->command);
  } else if (const auto* response = std::get_if<motion_action::ServoResponse>(&action)) {
    static_cast<void>(servo_responses_->Publish(ToWire(*response)));
  } else if (const auto* log = std::get_if<motion_action::Log>(&action)) {
    dependencies_.log(log->text);
  } else if (const auto* error = std::get_if<motion_action::ReportError>(&action)) {
    static_cast<void>(errors_->Publish({dependencies_.name, error->code}));
  } else if (const auto* say = std::get_if<motion_action::Say>(&action)) {
    static_cast<void>(
        speech_->Publish({dependencies_.name, true, {dependencies_.name, 0}, say->text}));
  } else if (const auto& answer = std::get<motion_action::Answer>(action);
             const auto waiting = waiting_.extract(answer.token)) {
    waiting.mapped()(answer);
  }
}

void MotionShell::Arm() {
  const auto deadline = NextDeadline(Rules(), core_);
  if (!deadline || *deadline == Time::max()) return timer_.reset();
  timer_ = dependencies_.clock.At(*deadline, [this] { Do(motion_event::TimePassed{}); });
}

}  // namespace musher::motion
