#include "musher/simulation/module_under_test.hpp"

#include <bit>
#include <condition_variable>
#include <future>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "musher/actuator/callback_harness.hpp"
#include "musher/lifecycle/code.hpp"

namespace musher::simulation {
namespace {

// Thrown out of StopRequested(): the process is killed.
struct Killed {};

// So many polls hand over each; of the later ones every power of two does, and takes the time for
// those between: who polls for ever is overdue soon.
constexpr std::uint64_t kCloseLook = 32;
constexpr Duration kLaterPoll = std::chrono::microseconds(10);

bool HandsOver(std::uint64_t poll) {
  return poll <= kCloseLook || std::has_single_bit(poll);
}

thread_local const void* on_stage = nullptr;  // whose callback this thread runs

}  // namespace

struct ModuleUnderTest::Stage {
  explicit Stage(std::uint64_t seed) : faults(seed) {}

  enum class Turn : std::uint8_t { kPolled, kEnded, kStuck };

  // Of the network's thread: the callback goes on to its next poll or its end.
  Turn Play(std::chrono::milliseconds limit) {
    std::unique_lock lock(mutex);
    playing = true;
    handed_over.notify_all();
    if (!handed_over.wait_for(lock, limit, [this] { return !playing; })) return Turn::kStuck;
    return ended ? Turn::kEnded : Turn::kPolled;
  }

  // Of the callback's thread.
  void Poll() {
    if (on_stage != this) return;  // a thread of the module's own
    std::unique_lock lock(mutex);
    if (killed) throw Killed{};
    if (!HandsOver(++polls)) return;
    playing = false;
    handed_over.notify_all();
    handed_over.wait(lock, [this] { return playing; });
    if (killed) throw Killed{};
  }

  void Perform(const State& state, bool repeat) {
    on_stage = this;
    {
      std::unique_lock lock(mutex);
      handed_over.wait(lock, [this] { return playing; });
    }
    Result<> first = killed ? Result<>(Error{kCodeFailed, "killed"}) : rehearsal->Run(state);
    std::optional<Error> second;
    if (repeat && first && !killed) {
      const Result<> again = rehearsal->Run(state);
      if (!again && !stop_requested) second = again.error();
    }
    const std::lock_guard lock(mutex);
    result = std::move(first);
    failed_again = std::move(second);
    playing = false;
    ended = true;
    handed_over.notify_all();
  }

  Faults faults;
  std::unique_ptr<MachineActuator> actuator;
  std::optional<CallbackHarness> rehearsal;
  std::mutex mutex;  // guards what follows
  std::condition_variable handed_over;
  bool playing = false;
  bool ended = false;
  bool killed = false;
  bool stop_requested = false;  // changes only while the callback waits
  bool stuck = false;           // a thread is given up: nothing else may touch the actuator
  std::uint64_t polls = 0;
  Result<> result = Ok();
  std::optional<Error> failed_again;
};

// Plays a callback, poll by poll.
class ModuleUnderTest::LockstepWorker : public Worker {
 public:
  LockstepWorker(ModuleUnderTest& module, transport::EventLoop& loop)
      : module_(module), stage_(module.stage_), loop_(loop) {}

  ~LockstepWorker() override {
    if (!thread_.joinable()) return;
    ++module_.production_.tally->killed_in;
    {
      const std::lock_guard lock(stage_->mutex);
      stage_->killed = true;
    }
    static_cast<void>(Play());
  }
  LockstepWorker(const LockstepWorker&) = delete;
  LockstepWorker& operator=(const LockstepWorker&) = delete;

  void Run(Work work, Done done) override {
    static_cast<void>(work());  // by which the module knows the state
    const ModuleUnderTest::Production& production = module_.production_;
    const Error& drawn = module_.act_.error;
    const State& state = module_.state_;
    rest_ = module_.act_.takes;
    done_ = std::move(done);
    ++production.tally->callbacks;
    const bool fails = drawn.code != kCodeOk;
    if (fails && !production.fails_by_itself) return EndAfter(rest_, drawn);  // at its first step
    stage_->faults.SetUnderWay(fails);
    stage_->ended = false;
    stage_->polls = 0;
    const bool repeat =
        module_.random_.Chance(0.125) && !fails && state != kSetUp && state != kTearDown;
    if (repeat) ++production.tally->repeated;
    thread_ = std::thread([stage = stage_, state, repeat] { stage->Perform(state, repeat); });
    Begin();
  }

 private:
  Stage::Turn Play() {
    const auto limit = module_.production_.real_time_limit;
    const Stage::Turn turn = stage_->Play(limit);
    if (turn == Stage::Turn::kEnded) thread_.join();
    if (turn == Stage::Turn::kStuck) {
      thread_.detach();  // nothing can end it; what it uses is its own now
      module_.GiveUp("its callback of " + module_.state_ +
                     " neither ends nor asks StopRequested()");
    }
    return turn;
  }

  // Some callbacks wait for their thread, so that an emergency stop may come before their first
  // instruction, as one may come after their last.
  void Begin() {
    module_.waits_ = module_.random_.Chance(0.5);
    if (!module_.waits_) return GoOn();
    const Duration wait = module_.random_.Between(Duration::zero(), rest_ / 2);
    rest_ -= wait;
    step_ = loop_.At(loop_.Now() + wait, [this] { GoOn(); });
  }

  void GoOn() {
    module_.waits_ = false;
    const Stage::Turn turn = Play();
    if (turn == Stage::Turn::kStuck) return;
    if (turn == Stage::Turn::kPolled) {
      Duration share = module_.random_.Between(Duration::zero(), rest_ / 4);
      rest_ -= share;
      if (stage_->polls > kCloseLook) share += stage_->polls * kLaterPoll;
      step_ = loop_.At(loop_.Now() + share, [this] { GoOn(); });
      return;
    }
    const auto& again = stage_->failed_again;
    if (again) {
      module_.production_.complain("its callback of " + module_.state_ +
                                   " was done, and failed when it was run again: " +
                                   CodeText(again->code) + " " + again->message);
    }
    if (stage_->stop_requested) ++module_.production_.tally->asked_to_stop;
    EndAfter(stage_->stop_requested ? Duration::zero() : rest_, stage_->result);
  }

  void EndAfter(Duration rest, const Result<>& result) {
    step_ = loop_.At(loop_.Now() + rest, [this, result] {
      if (!result) ++module_.production_.tally->failed;
      module_.ended_ = result.ok();
      done_(result);
    });
  }

  ModuleUnderTest& module_;
  const std::shared_ptr<Stage> stage_;
  transport::EventLoop& loop_;
  Duration rest_{};  // that the callback takes yet
  Done done_;
  std::thread thread_;
  transport::LoopHandlePtr step_;
};

ModuleUnderTest::ModuleUnderTest(const Production& production, Scenario::Draw draw,
                                 std::uint64_t seed)
    : production_(production),
      draw_(std::move(draw)),
      random_(seed),
      stage_(std::make_shared<Stage>(random_.Next())) {
  ++production_.tally->processes;
  stage_->actuator = production_.make(stage_->faults);
  stage_->rehearsal.emplace(*stage_->actuator);
  // That it fits has been found before the first scenario.
  if (production_.config != nullptr) {
    static_cast<void>(stage_->rehearsal->Adopt(*production_.config));
  }
  stage_->rehearsal->SetBattery(production_.battery);
  stage_->rehearsal->OnPoll([stage = stage_.get()] { stage->Poll(); });
}

ModuleUnderTest::~ModuleUnderTest() = default;

Act ModuleUnderTest::Run(const State& state) {
  state_ = state;
  act_ = draw_(state);
  ended_.reset();
  return act_;
}

std::unique_ptr<Worker> ModuleUnderTest::MakeWorker(transport::EventLoop& loop) {
  return std::make_unique<LockstepWorker>(*this, loop);
}

void ModuleUnderTest::SetStopRequested(bool requested) {
  stage_->stop_requested = requested;
  stage_->rehearsal->SetStopRequested(requested);
}

void ModuleUnderTest::GiveUp(const std::string& why) {
  stage_->stuck = true;
  production_.on_stuck();
  production_.complain(why + " for " + std::to_string(production_.real_time_limit.count()) +
                       " ms of real time");
}

void ModuleUnderTest::OnEmergencyStop() {
  if (stage_->stuck) return;
  ++production_.tally->emergency_stops;
  if (report_.busy()) ++production_.tally->stopped_beside;
  if (waits_) ++production_.tally->stopped_before;
  std::promise<Result<>> invariant;
  std::future<Result<>> done = invariant.get_future();
  std::thread thread([stage = stage_, invariant = std::move(invariant)]() mutable {
    invariant.set_value(stage->rehearsal->EmergencyStop());
  });
  if (done.wait_for(production_.real_time_limit) != std::future_status::ready) {
    thread.detach();
    return GiveUp("its OnEmergencyStop() does not come back beside a callback of " + state_);
  }
  thread.join();
  if (const Result<> result = done.get(); !result) {
    production_.complain("its OnEmergencyStop() failed: " + result.error().message);
  }
  production_.check_stop(*stage_->actuator, report_);
  if (!report_.busy() && settled_) production_.check(*stage_->actuator, report_);
}

void ModuleUnderTest::OnReport(const ActuatorReport& report) {
  report_ = report;
  if (stage_->stuck) return;
  stage_->rehearsal->SetReport(report);
  if (!ended_ || report.target == state_) return;  // its end is not noticed yet
  // One that ended well under an emergency stop may have failed all the same.
  const bool taken = state_ == kSelfCheck || report.state == state_;
  settled_ = *std::exchange(ended_, std::nullopt) && taken;
  // Its output must be off by itself, before the stop action runs again.
  if (!settled_ && report.emergency_stop != 0) production_.check_stop(*stage_->actuator, report);
  if (settled_ && state_ == kTearDown) ++production_.tally->torn_down;
  if (settled_) production_.check(*stage_->actuator, report);
}

}  // namespace musher::simulation
