#include "musher/simulation/module_under_test.hpp"

#include <bit>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <utility>

#include "musher/actuator/callback_harness.hpp"
#include "musher/base/code.hpp"

namespace musher::simulation {
namespace {

// Thrown out of StopRequested(): the process is killed.
struct Killed {};

// Each of so many polls hands over to the simulation. Of the later ones each power of two does, and
// takes the time of those between, so that a callback that polls endlessly is soon overdue.
constexpr std::uint64_t kEachPollHandsOver = 32;
// After the end of the callback that it waited for, also on a busy computer.
constexpr auto kStopEndsWithin = std::chrono::seconds(10);
constexpr Duration kLaterPoll = std::chrono::microseconds(10);

bool HandsOver(std::uint64_t poll) {
  return poll <= kEachPollHandsOver || std::has_single_bit(poll);
}

thread_local const void* current_callback = nullptr;  // whose callback runs on this thread

// `limit` is waited in steps, each of which counts as its length however late it ends: where the
// computer has no time for this process, what it waits for has had none either.
bool WaitInSteps(std::chrono::milliseconds limit,
                 const std::function<bool(std::chrono::milliseconds)>& ready_within) {
  constexpr auto kStep = std::chrono::milliseconds(1);
  for (auto waited = kStep; waited <= limit; waited += kStep) {
    if (ready_within(kStep)) return true;
  }
  return false;
}

}  // namespace

struct ModuleUnderTest::CallbackThread {
  explicit CallbackThread(std::uint64_t seed) : faults(seed) {}
  ~CallbackThread() {
    // A callback that was given up ends on its own thread, when the network may be destroyed: the
    // actuator and its node are never destroyed.
    if (stuck && actuator && actuator->node()) {
      static_cast<void>(actuator.release());
    } else if (actuator) {
      actuator->Shutdown();  // its endpoints use members of its class
    }
  }
  CallbackThread(const CallbackThread&) = delete;
  CallbackThread& operator=(const CallbackThread&) = delete;

  enum class Turn : std::uint8_t { kPolled, kEnded, kStuck };

  // On the network's thread: lets the callback run to its next poll or its end.
  Turn Resume(std::chrono::milliseconds limit) {
    std::unique_lock lock(mutex);
    running = true;
    handed_over.notify_all();
    const bool done = WaitInSteps(limit, [&](std::chrono::milliseconds step) {
      return handed_over.wait_for(lock, step, [this] { return !running; });
    });
    if (!done) return Turn::kStuck;
    return ended ? Turn::kEnded : Turn::kPolled;
  }

  // On the callback's thread.
  void Poll() {
    if (current_callback != this) return;  // another thread of the module
    std::unique_lock lock(mutex);
    if (killed) throw Killed{};
    if (!HandsOver(++polls)) return;
    running = false;
    handed_over.notify_all();
    handed_over.wait(lock, [this] { return running; });
    if (killed) throw Killed{};
  }

  void RunCallback(const State& state, bool repeat) {
    current_callback = this;
    {
      std::unique_lock lock(mutex);
      handed_over.wait(lock, [this] { return running; });
    }
    Result<> first = killed ? Result<>(Error{kCodeFailed, "killed"}) : harness->Run(state);
    std::optional<Error> second;
    if (repeat && first && !killed) {
      const Result<> again = harness->Run(state);
      if (!again && !stop_requested) second = again.error();
    }
    const std::lock_guard lock(mutex);
    result = std::move(first);
    repeat_error = std::move(second);
    running = false;
    ended = true;
    handed_over.notify_all();
  }

  Faults faults;
  std::unique_ptr<MachineActuator> actuator;
  std::optional<CallbackHarness> harness;
  std::mutex mutex;  // guards what follows
  std::condition_variable handed_over;
  bool running = false;
  bool ended = false;
  bool killed = false;
  bool stop_requested = false;  // changes only while the callback waits
  bool stuck = false;           // its thread is given up: nothing may use the actuator any more
  std::uint64_t polls = 0;
  Result<> result = Ok();
  std::optional<Error> repeat_error;
};

// Runs a callback, poll by poll.
class ModuleUnderTest::LockstepWorker : public Worker {
 public:
  LockstepWorker(ModuleUnderTest& module, transport::EventLoop& loop)
      : module_(module), callback_(module.callback_), loop_(loop) {}

  ~LockstepWorker() override {
    if (!thread_.joinable()) return;
    ++module_.setup_.counts->killed;
    {
      const std::lock_guard lock(callback_->mutex);
      callback_->killed = true;
    }
    static_cast<void>(Resume());
  }
  LockstepWorker(const LockstepWorker&) = delete;
  LockstepWorker& operator=(const LockstepWorker&) = delete;

  void Run(Work work, Done done) override {
    static_cast<void>(work());  // passes the state to the module
    const ModuleUnderTest::Setup& setup = module_.setup_;
    const Error& injected = module_.act_.error;
    const State& state = module_.state_;
    rest_ = module_.act_.takes;
    done_ = std::move(done);
    ++setup.counts->callbacks;
    const bool fails = injected.code != kCodeOk;
    if (fails && !setup.fails_by_itself) return EndAfter(rest_, injected);  // at its first step
    callback_->faults.SetUnderWay(fails);
    callback_->ended = false;
    callback_->polls = 0;
    const bool repeat =
        module_.random_.Bernoulli(0.125) && !fails && state != kSetUp && state != kTearDown;
    if (repeat) ++setup.counts->repeated;
    thread_ = std::thread(
        [callback = callback_, state, repeat] { callback->RunCallback(state, repeat); });
    Begin();
  }

 private:
  CallbackThread::Turn Resume() {
    const auto limit = module_.setup_.real_time_limit;
    const CallbackThread::Turn turn = callback_->Resume(limit);
    if (turn == CallbackThread::Turn::kEnded) thread_.join();
    if (turn == CallbackThread::Turn::kStuck) {
      thread_.detach();  // nothing can end the thread, and what it uses stays alive
      module_.GiveUp("its callback of " + module_.state_ +
                     " neither ends nor calls StopRequested()");
    }
    return turn;
  }

  // Half of the callbacks wait for their thread, so that an emergency stop can be engaged before
  // their first instruction.
  void Begin() {
    module_.waits_ = module_.random_.Bernoulli(0.5);
    if (!module_.waits_) return Continue();
    const Duration wait = module_.random_.Between(Duration::zero(), rest_ / 2);
    rest_ -= wait;
    step_ = loop_.At(loop_.Now() + wait, [this] { Continue(); });
  }

  void Continue() {
    module_.waits_ = false;
    const CallbackThread::Turn turn = Resume();
    if (turn == CallbackThread::Turn::kStuck) return;
    if (turn == CallbackThread::Turn::kPolled) {
      Duration share = module_.random_.Between(Duration::zero(), rest_ / 4);
      rest_ -= share;
      if (callback_->polls > kEachPollHandsOver) share += callback_->polls * kLaterPoll;
      step_ = loop_.At(loop_.Now() + share, [this] { Continue(); });
      return;
    }
    const auto& again = callback_->repeat_error;
    if (again) {
      module_.setup_.report_error("its callback of " + module_.state_ +
                                  " was done, and fails when it runs again: " +
                                  CodeText(again->code) + " " + again->message);
    }
    if (callback_->stop_requested) ++module_.setup_.counts->stop_requested;
    EndAfter(callback_->stop_requested ? Duration::zero() : rest_, callback_->result);
  }

  void EndAfter(Duration rest, const Result<>& result) {
    step_ = loop_.At(loop_.Now() + rest, [this, result] {
      if (!result) ++module_.setup_.counts->failed;
      module_.ended_ = result.ok();
      done_(result);
    });
  }

  ModuleUnderTest& module_;
  const std::shared_ptr<CallbackThread> callback_;
  transport::EventLoop& loop_;
  Duration rest_{};  // the remaining time of the callback
  Done done_;
  std::thread thread_;
  transport::LoopHandlePtr step_;
};

ModuleUnderTest::ModuleUnderTest(const Setup& setup, Scenario::ActSampler sample_act,
                                 std::uint64_t seed)
    : setup_(setup),
      sample_act_(std::move(sample_act)),
      random_(seed),
      callback_(std::make_shared<CallbackThread>(random_.Next())) {
  ++setup_.counts->processes;
  callback_->actuator = setup_.make(callback_->faults);
  callback_->harness.emplace(*callback_->actuator);
  // Whether it fits was checked before the first scenario.
  if (setup_.config != nullptr) {
    static_cast<void>(callback_->harness->Adopt(*setup_.config));
  }
  if (setup_.make_node) callback_->harness->SetNode(setup_.make_node());
  callback_->harness->SetBattery(setup_.battery);
  callback_->harness->OnPoll([callback = callback_.get()] { callback->Poll(); });
}

// Its callback has ended by now, or is given up. A stop that never returns stays, with what it
// uses.
ModuleUnderTest::~ModuleUnderTest() {
  if (!stop_.joinable()) return;
  const bool ended = stop_done_.wait_for(kStopEndsWithin) == std::future_status::ready;
  ended ? stop_.join() : stop_.detach();
}

Act ModuleUnderTest::Run(const State& state) {
  state_ = state;
  act_ = sample_act_(state);
  ended_.reset();
  return act_;
}

std::unique_ptr<Worker> ModuleUnderTest::MakeWorker(transport::EventLoop& loop) {
  return std::make_unique<LockstepWorker>(*this, loop);
}

void ModuleUnderTest::SetStopRequested(bool requested) {
  callback_->stop_requested = requested;
  callback_->harness->SetStopRequested(requested);
}

void ModuleUnderTest::GiveUp(const std::string& why) {
  callback_->stuck = true;
  setup_.on_stuck();
  setup_.report_error(why + " for " + std::to_string(setup_.real_time_limit.count()) +
                      " ms of real time");
}

void ModuleUnderTest::OnEmergencyStop() {
  if (callback_->stuck) return;
  ++setup_.counts->emergency_stops;
  if (report_.busy()) ++setup_.counts->stops_during_callback;
  if (waits_) ++setup_.counts->stops_before_callback;
  std::promise<Result<>> promise;
  std::future<Result<>> done = promise.get_future();
  std::thread thread([callback = callback_, promise = std::move(promise)]() mutable {
    promise.set_value(callback->harness->EmergencyStop());
  });
  const bool returned =
      WaitInSteps(setup_.real_time_limit, [&done](std::chrono::milliseconds step) {
        return done.wait_for(step) == std::future_status::ready;
      });
  if (!returned) {
    stop_ = std::move(thread);
    stop_done_ = std::move(done);
    return GiveUp("its OnEmergencyStop() does not return during a callback of " + state_);
  }
  thread.join();
  if (const Result<> result = done.get(); !result) {
    setup_.report_error("its OnEmergencyStop() failed: " + result.error().message);
  }
  setup_.check_stop(*callback_->actuator, report_);
  if (!report_.busy() && settled_) setup_.check(*callback_->actuator, report_);
}

void ModuleUnderTest::OnReport(const ActuatorReport& report) {
  report_ = report;
  if (callback_->stuck) return;
  callback_->harness->SetReport(report);
  if (!ended_ || report.target == state_) return;  // the actuator has not noticed its end yet
  // A callback that succeeded during an emergency stop may count as failed.
  const bool taken = state_ == kSelfCheck || report.state == state_;
  settled_ = *std::exchange(ended_, std::nullopt) && taken;
  // The module must have switched off its output itself, before the stop action runs again.
  if (!settled_ && report.emergency_stop != 0) setup_.check_stop(*callback_->actuator, report);
  if (settled_ && state_ == kTearDown) ++setup_.counts->torn_down;
  if (settled_) setup_.check(*callback_->actuator, report);
}

}  // namespace musher::simulation
