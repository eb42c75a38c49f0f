#include "musher/modules/motion/motion_manager.hpp"

#include <functional>
#include <optional>
#include <utility>

#include "musher/actuator/program/await.hpp"
#include "musher/cyberdog/codes/module_codes.hpp"
#include "musher/modules/motion/lcm_backend.hpp"
#include "musher/modules/motion/topic_backend.hpp"

namespace musher::motion {
namespace {

constexpr int kLowPowerTries = 3;
constexpr int kUntilItLies = 0;

}  // namespace

MotionManager::MotionManager(const std::string& actuator_name, MotionConfig config,
                             MotionTable table)
    : MachineActuator(actuator_name), config_(std::move(config)), table_(std::move(table)) {
  RegisterStateCallback([this](const State& state) { return Run(state); });
}

MotionManager::~MotionManager() {
  if (!loop_) return;
  loop_->RunOnLoop([this] {
    shell_.reset();
    clock_.reset();
  });
}

// It is stopped once its board reports that.
void MotionManager::OnEmergencyStop() {
  if (!shell_) return ReportStopTrouble("it is not set up: no stop was sent to the motion board");
  shell_->Do(motion_event::EmergencyStop{});
  ReportStopTrouble(shell_->stop_trouble());
}

Result<> MotionManager::Run(const State& state) {
  if (state == kSetUp) return SetUp();
  if (state == kSelfCheck) return SelfCheck();
  if (state == kDeActive || state == kError) return Close(state);
  if (state == kLowPower) return CloseLying(state, kGetDown, kLowPowerTries);
  if (state == kOta) return CloseLying(state, kGetDown, kUntilItLies);
  if (state == kTearDown) return CloseLying(state, kPassiveGetDown, kUntilItLies);
  return Open();  // Active, Protected, and states added by a config
}

Result<> MotionManager::SetUp() {
  if (!loop_) loop_ = node();
  if (!loop_) {
    return Error{MotionCode(KeyCode::kUninitialized), "there is no node to move a body from"};
  }
  Result<> opened;
  loop_->RunOnLoop([&] {
    if (!shell_) opened = OpenShell();
  });
  return opened ? AwaitBody() : opened;
}

// On the loop.
Result<> MotionManager::OpenShell() {
  transport::Node& node = loop_->node();
  auto clock = transport::Clock::Of(machine_config().clock, node, [this] {
    const std::string why = clock_->JumpText();
    // A result has no more than its code, that of a silent board.
    jumps_.Log("jump", why + "; a motion that was under way has ended", loop_->loop().Now());
    if (shell_) shell_->Do(motion_event::WorldRestarted{why});
  });
  if (!clock) return clock.error();
  clock_ = std::move(clock).value();
  if (const auto warning = WarningOfClock(config_, machine_config().clock)) Log(*warning);
  const std::string& name_space = machine_config().name_space;
  auto shell = MotionShell::Make(
      {node, *clock_, table_, config_, name_space,
       [this](const std::string& capability) {
         return Allowed(capability, cyberdog::module_code::kMotionManager);
       },
       [this](const std::string& text) { Log(text); }, name(),
       [this](const std::string& trouble) { ReportStopTrouble(trouble); },
       !machine_config().keys.empty(),
       [this, loop = std::weak_ptr(loop_)](MotionShell::Background work) {
         files_.Do([loop, work = std::move(work)] {
           std::function<void()> then = work();  // perhaps long after the end of this manager
           if (const auto thread = loop.lock()) thread->loop().Post(std::move(then));
         });
       }},
      [this](MotionBackend::OnBody on_body) { return MakeBackend(std::move(on_body)); });
  if (!shell) return shell.error();
  shell_ = std::move(shell).value();
  if (EmergencyStopped()) shell_->Do(motion_event::EmergencyStop{});
  return Ok();
}

Result<std::unique_ptr<MotionBackend>> MotionManager::MakeBackend(MotionBackend::OnBody on_body) {
  if (config_.board == BoardKind::kLcm) return MakeLcmBackend(std::move(on_body));
  auto backend = TopicBackend::Make(loop_->node(), machine_config().name_space, std::move(on_body),
                                    [this](std::int32_t code, const std::string& text) {
                                      if (shell_) shell_->Do(motion_event::BoardFault{code, text});
                                    });
  if (!backend) return backend.error();
  return std::unique_ptr<MotionBackend>(std::move(backend).value());
}

// The shell exists when the events come: they come from the loop, which makes it now.
Result<std::unique_ptr<MotionBackend>> MotionManager::MakeLcmBackend(
    MotionBackend::OnBody on_body) {
  LcmBackend::Events events;
  events.on_body = std::move(on_body);
  events.on_restart = [this] {
    if (shell_) shell_->Do(motion_event::BoardRestarted{});
  };
  events.on_held = [this](const std::string& why) {
    if (shell_) shell_->Do(motion_event::BoardHeld{why});
  };
  events.on_fault = [this](std::int32_t code, const std::string& text) {
    if (shell_) shell_->Do(motion_event::BoardFault{code, text});
  };
  events.on_other_gait = [this](const std::string& why) {
    if (shell_) shell_->Do(motion_event::OtherGait{why});
  };
  auto backend =
      std::make_unique<LcmBackend>(loop_->node().loop(), *clock_, config_, std::move(events));
  Log("the motion board is expected on " + backend->Source());
  return std::unique_ptr<MotionBackend>(std::move(backend));
}

// The body, and the network to it, may be switched on a little later than this module.
Result<> MotionManager::AwaitBody() {
  const auto reported = std::make_shared<bool>(false);
  OnLoop([&](MotionShell& shell) { shell.OnNextReport([reported] { *reported = true; }); });
  const auto check = [&]() -> Result<> {
    if (*reported) return Ok();
    if (auto reachable = shell_->reachable(); !reachable) return reachable;
    return Error{MotionCode(MotionKey::kBoardSilent),
                 "the motion board is silent: no report on " + shell_->board() + " within " +
                     std::to_string(ToMilliseconds(config_.board_wait)) + " ms"};
  };
  return program::AwaitOnLoop(*loop_, config_.board_wait, check,
                              [this] { return StopRequested(); });
}

// Another commander of the board may send as rarely as twice a second.
Result<> MotionManager::SelfCheck() {
  if (!loop_) return Ok();
  const auto known = [this]() -> Result<> {
    if (!shell_ || shell_->knows_commanders()) return Ok();
    return Error{MotionCode(KeyCode::kTimeout), "it has not received for long enough"};
  };
  static_cast<void>(
      program::AwaitOnLoop(*loop_, 2 * kOtherSender, known, [this] { return StopRequested(); }));
  Result<> checked;
  OnLoop([&](MotionShell& shell) { checked = shell.Check(); });
  return checked;
}

Result<> MotionManager::Open() {
  OnLoop([](MotionShell& shell) { shell.Do(motion_event::Opened{}); });
  return Ok();
}

Result<> MotionManager::Close(const State& state) {
  OnLoop([&](MotionShell& shell) { shell.Do(motion_event::Closed{state}); });
  return Ok();
}

Result<> MotionManager::CloseLying(const State& state, std::int32_t get_down, int tries) {
  using motion_action::Answer;
  const auto answer = std::make_shared<std::optional<Answer>>();
  RequestToken token = 0;
  OnLoop([&](MotionShell& shell) {
    shell.Do(motion_event::Closed{state});
    token = shell.LieDown(get_down, tries, [answer](const Answer& a) { *answer = a; });
  });
  if (token == 0) return Ok();  // never set up: the body was not moved
  const Error unanswered{MotionCode(KeyCode::kTimeout), "it has not ended yet"};
  static_cast<void>(program::AwaitOnLoop(
      *loop_, TimeToLie(state), [&] { return *answer ? Ok() : Result<>(unanswered); },
      [this] { return StopRequested(); }));
  OnLoop([&](MotionShell& shell) {
    if (!*answer) shell.Do(motion_event::Cancelled{token});
  });
  const Result<> lies = !*answer                     ? Result<>(unanswered)
                        : (*answer)->code == kCodeOk ? Ok()
                                                     : Error{(*answer)->code, (*answer)->message};
  if (lies) return Ok();
  return Error{lies.error().code, "the body does not lie: " + lies.error().message};
}

void MotionManager::OnLoop(const std::function<void(MotionShell&)>& work) {
  if (!loop_) return;
  loop_->RunOnLoop([&] {
    if (shell_) work(*shell_);
  });
}

// A little less than the caller's time, so that the caller still gets the reason.
Duration MotionManager::TimeToLie(const State& state) const {
  const MachineConfig& machine = machine_config();
  return machine.TimeFor(*machine.IndexOf(name()), state) * 9 / 10;
}

}  // namespace musher::motion
