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
// As tf2 has it.
constexpr transport::Qos kTfQos{transport::Qos::Reliability::kReliable,
                                transport::Qos::Durability::kVolatile, 100};

}  // namespace

Result<std::unique_ptr<MotionShell>> MotionShell::Make(Dependencies dependencies,
                                                       const MakeBackend& make_backend) {
  std::unique_ptr<MotionShell> shell(new MotionShell(std::move(dependencies)));
  if (auto opened = shell->Open(make_backend); !opened) return opened.error();
  return shell;
}

MotionShell::MotionShell(Dependencies dependencies)
    : dependencies_(std::move(dependencies)),
      endpoints_(dependencies_.node, dependencies_.name_space) {}

Result<> MotionShell::Open(const MakeBackend& make_backend) {
  OpenTopics();
  OpenFrames();
  if (!endpoints_.opened()) return endpoints_.opened();
  auto backend = make_backend([this](const BodyState& body) { OnBody(body); });
  if (!backend) return backend.error();
  backend_ = std::move(backend).value();
  OpenServices();
  if (!endpoints_.opened()) return endpoints_.opened();
  status_timer_ = dependencies_.clock.Every(kStatusPeriod, [this] { PublishStatus(); });
  transport::EventLoop& loop = dependencies_.node.loop();
  turns_ = loop.Every(LoopPause::kPeriod, [this, &loop] { loop_pause_.OnTurn(loop.Now()); });
  return Ok();
}

void MotionShell::OpenTopics() {
  servo_responses_ = endpoints_.Advertise<msg::MotionServoResponse>("motion_servo_response");
  status_ = endpoints_.Advertise<msg::MotionStatus>("motion_status");
  odometry_ = endpoints_.Advertise<msg::Odometry>("odom_out");
  imu_ = endpoints_.Advertise<msg::Imu>("imu");
  errors_ = endpoints_.Advertise<msg::NodeError>("node_errors");
  speech_ = endpoints_.Advertise<msg::AudioPlayExtend>("speech_play_extend");
  endpoints_.Subscribe<msg::MotionServoCmd>(
      "motion_servo_cmd",
      [this](const msg::MotionServoCmd& command) {
        Do(motion_event::ServoArrived{FromWire(command)});
      },
      transport::kSystemDefaultQos);
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
      "motion_result_cmd", [this](const auto& request, auto reply) {
        Play(request.cmd_source, MotionRequests{FromWire(request)}, [reply](const Answer& answer) {
          reply({answer.motion_id, answer.code == kCodeOk, answer.code});
        });
      });
  endpoints_.Serve<msg::MotionCustomCmd>(
      "motion_custom_cmd", [this](const auto& request, auto reply) {
        const std::int32_t id = request.motion_id;
        const OnAnswer on_answer = [id, reply](const Answer& answer) {
          reply({id, answer.code == kCodeOk, answer.code});
        };
        const bool defines = request.cmd_type == msg::MotionCustomCmd::kDefinition;
        if (defines && backend_->TakesGaits()) return DefineFromFiles(request, on_answer);
        Play(request.cmd_source, RequestsOf(request), on_answer);
      });
  endpoints_.Serve<msg::MotionQueueCustomCmd>(
      "motion_queue_cmd", [this](const auto& request, auto reply) {
        Play(kFromApp, RequestsOf(dependencies_.table, request), [reply](const Answer& answer) {
          reply({answer.code == kCodeOk, answer.code});
        });
      });
  endpoints_.Serve<msg::MotionSequenceShow>(
      "motion_sequence_cmd", [this](const auto& request, auto reply) {
        const std::int32_t id = request.motion_id;
        const OnAnswer on_answer = [id, reply](const Answer& answer) {
          reply({answer.code == kCodeOk, answer.code, answer.message, id});
        };
        if (HasUserGait(request) && backend_->TakesGaits()) {
          return PlayUserGait(request, on_answer);
        }
        Play(request.cmd_source, RequestsOf(request), on_answer);
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
  const Time now = dependencies_.node.loop().Now();
  loop_pause_.OnTurn(now);
  if (!loop_pause_.HasEnded(now)) return Ok();
  return Error{MotionCode(KeyCode::kTimeout),
               "the motion manager stood still for a while, and its caller may have given up; "
               "request it again"};
}

void MotionShell::Play(std::int32_t source, const Result<MotionRequests>& requests,
                       OnAnswer on_answer) {
  if (!requests) {
    dependencies_.log("a command of " + SourceName(source) +
                      " is refused: " + requests.error().message + " (" +
                      std::to_string(requests.error().code) + ")");
    return on_answer({0, 0, requests.error().code, requests.error().message});
  }
  const bool stops = std::ranges::count(requests.value(), kEmergencyStop, &MotionRequest::id) > 0;
  const auto fresh = stops ? Ok() : CheckFresh();
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
    if (motion == nullptr || !PlaysUserGait(*motion) || defined_ == request.id) continue;
    return Error{MotionCode(MotionKey::kSequenceDefinition), "the board has no gait of motion " +
                                                                 std::to_string(request.id) +
                                                                 ": its DEFINITION is first"};
  }
  return Ok();
}

// --- gaits of users ---

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

void MotionShell::DefineFromFiles(const msg::MotionCustomCmd::Request& request,
                                  OnAnswer on_answer) {
  const std::int32_t id = request.motion_id;
  Define(request.cmd_source, id, GaitOfFiles(id),
         [id, on_answer = std::move(on_answer)](const Result<>& defined) {
           on_answer(defined ? motion_action::Answer{0, id, kCodeOk, ""}
                             : motion_action::Answer{0, id, defined.error().code,
                                                     defined.error().message});
         });
}

Result<UserGait> MotionShell::GaitOfFiles(std::int32_t id) const {
  const Motion* motion = dependencies_.table.Find(id);
  if (motion == nullptr || !PlaysUserGait(*motion)) {
    return Error{MotionCode(KeyCode::kUnSupport),
                 "motion " + std::to_string(id) + " cannot be defined: it does not play gait 110"};
  }
  const std::string begin = dependencies_.config.gaits + "/" + std::to_string(id);
  std::array<std::string, 2> texts;
  for (std::size_t i = 0; i < texts.size(); ++i) {
    const std::string file = begin + (i == 0 ? ".sections.toml" : ".steps.toml");
    auto text = config_toml::ReadModuleText(file);
    if (!text) return Error{MotionCode(KeyCode::kUnSupport), file + ": " + text.error().message};
    texts[i] = std::move(text).value();
  }
  return ReadUserGait(texts[0], texts[1]);
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
  Define(source, id, gait,
         [this, source, id, on_answer = std::move(on_answer)](const Result<>& defined) {
           if (defined) return Play(source, MotionRequests{{id, {}}}, on_answer);
           on_answer({0, id, defined.error().code, defined.error().message});
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
  for (const MotionAction& action : Step(Rules(), core_, event, dependencies_.clock.Now())) {
    Perform(action);
  }
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
