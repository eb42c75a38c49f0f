#include "musher/modules/motion/motion_shell.hpp"

#include <algorithm>
#include <utility>

#include "musher/modules/motion/motion_wire.hpp"

namespace musher::motion {
namespace {

constexpr Duration kStatusPeriod = Milliseconds(100);

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
  endpoints_.Subscribe<msg::MotionServoCmd>(
      "motion_servo_cmd",
      [this](const msg::MotionServoCmd& command) {
        Do(motion_event::ServoArrived{FromWire(command)});
      },
      transport::kSystemDefaultQos);
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
        Play(request.cmd_source, RequestsOf(request), [id, reply](const Answer& answer) {
          reply({id, answer.code == kCodeOk, answer.code});
        });
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
        Play(request.cmd_source, RequestsOf(request), [id, reply](const Answer& answer) {
          reply({answer.code == kCodeOk, answer.code, answer.message, id});
        });
      });
  endpoints_.Serve<msg::MotorTemp>("motor_temp",
                                   [this](const auto&, auto reply) { reply(Temperatures()); });
}

void MotionShell::OnBody(const BodyState& body) {
  Do(motion_event::BoardReported{body.report});
  if (body.has_new_motion) {
    // No caller to report a failure to; the next one follows in 20 ms.
    static_cast<void>(odometry_->Publish(OdometryOf(body.motion)));
    static_cast<void>(imu_->Publish(ImuOf(body.motion)));
  }
  for (const auto& then : std::exchange(next_report_callbacks_, {})) then();
}

void MotionShell::Play(std::int32_t source, const Result<MotionRequests>& requests,
                       OnAnswer on_answer) {
  if (!requests) {
    dependencies_.log("a command of " + SourceName(source) +
                      " is refused: " + requests.error().message + " (" +
                      std::to_string(requests.error().code) + ")");
    return on_answer({0, 0, requests.error().code, requests.error().message});
  }
  waiting_[++token_] = std::move(on_answer);
  Do(motion_event::PlayArrived{token_, source, requests.value()});
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
  for (const MotionAction& action : Step(Rules(), core_, event, dependencies_.clock.Now())) {
    Perform(action);
  }
  Arm();
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
