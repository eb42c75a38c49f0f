// Skills that decide pseudo-randomly, under random starts, steps, clock jumps, cancellations,
// pauses, resets and restores: what must always hold.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "musher/behavior/skill/compose.hpp"
#include "musher/behavior/skill/snapshot.hpp"
#include "musher/test/behavior/fsm/random_states.hpp"

namespace musher::skill::property_test {

using fsm::Mix;

constexpr Duration kRunLimit = std::chrono::seconds(30);
constexpr Duration kCancelLimit = std::chrono::seconds(2);
constexpr int kRetries = 2;
constexpr std::size_t kStates = 4;

// What a skill did, for the checks.
struct Truth {
  bool succeeds = false;  // the last decision was a success, and nothing has failed
  int ends = 0;           // calls of OnEnd
};

class RandomSkill : public Skill {
 public:
  RandomSkill(std::uint64_t seed, Truth& truth) : seed_(seed), truth_(truth) {}

  void Declare(Table& table) override {
    for (std::size_t i = 0; i < kStates; ++i) {
      const bool limited = Mix(seed_ + i) % 2 == 0;
      table.State("S" + std::to_string(i), limited ? std::chrono::seconds(3) : kNoLimit);
    }
    for (std::size_t i = 0; i < kStates; ++i) {
      for (std::size_t k = 0; k < kStates; ++k) {
        if (Mix(seed_ + 7 * i + 31 * k) % 4 != 0) table.To(At(i), At(k), "at random");
      }
      if (i != 1) table.To(At(i), kSucceeded, "at random");
      table.To(At(i), kFailed, "at random");
    }
    if (seed_ % 2 == 0) table.MonotoneProgress();
    table.Limit({.run = kRunLimit, .cancel = kCancelLimit, .retries = kRetries});
  }
  Next Step(Tick& tick) override { return Decide(tick, 1); }
  Next Cancel(Tick& tick) override { return Decide(tick, 2); }
  Next OnLimit(Tick& tick) override { return Decide(tick, 3); }
  void OnEnd(const Ended&) override {
    ++truth_.ends;
    MayThrow(4);
  }
  void OnPause() override { MayThrow(5); }
  void OnResume() override { MayThrow(6); }
  void Persist(fsm::Archive& archive) override { archive.Field("calls", calls_); }

 private:
  static StateId At(std::size_t i) { return static_cast<StateId>(4 + i); }
  std::uint64_t Bits(std::uint64_t phase) {
    return Mix(seed_ + Mix(static_cast<std::uint64_t>(++calls_) * 8 + phase));
  }
  void MayThrow(std::uint64_t phase) {
    if (Bits(phase) % 40 != 0) return;
    truth_.succeeds = false;
    throw std::runtime_error("at random");
  }
  Next Decide(Tick& tick, std::uint64_t phase) {
    truth_.succeeds = false;
    MayThrow(phase);
    const std::uint64_t bits = Bits(phase + 8);
    constexpr double kInfinite = std::numeric_limits<double>::infinity();
    const std::array<double, 8> progress{-3, 0, 12, 55.5, 100, 250, std::nan(""), kInfinite};
    if (bits % 2 == 0) tick.Report(progress[(bits >> 4) % 8], "random");
    tick.Detail("bits", static_cast<double>(bits % 100));
    const StateId to = At((bits >> 8) % (kStates + (bits % 64 == 1 ? 1 : 0)));
    switch ((bits >> 16) % 24) {
      case 0:
      case 1:
        return Next::To(to);
      case 2:
        return Next::Retry(to, "slipped");
      case 3:
        return Next::Replan(to, "moved");
      case 4:
        truth_.succeeds = true;
        return Next::Succeed("done");
      case 5:
        return Next::Fail("failed");
      case 6:
        return Next::Cancelled("by itself");
      default:
        return Next::Stay();
    }
  }

  const std::uint64_t seed_;
  Truth& truth_;
  std::int64_t calls_ = 0;
};

struct Input {
  int kind = 0;
  std::int64_t value = 0;
};

std::vector<Input> AnyInput() {
  return *rc::gen::container<std::vector<Input>>(rc::gen::apply(
      [](int kind, std::int64_t value) {
        return Input{kind, value};
      },
      rc::gen::weightedElement<int>(
          {{30, 0}, {5, 1}, {2, 2}, {1, 3}, {1, 4}, {1, 5}, {1, 6}, {1, 7}}),
      rc::gen::inRange<std::int64_t>(0, 120)));
}

// Two skills, and compositions of them that use other ones.
class Robot {
 public:
  explicit Robot(std::uint64_t seed) {
    for (std::size_t i = 0; i < kSkills.size(); ++i) {
      const std::uint64_t own = Mix(seed * 10 + i);
      RC_ASSERT(registry_.Add(kSkills[i], Factory([this, own, i] {
                                return std::make_unique<RandomSkill>(own, truths_[i]);
                              })));
    }
    const Order order = static_cast<Order>(seed % 3);
    RC_ASSERT(registry_.Add("all", Compose(order, registry_, {{"c"}, {"d"}, {"e"}})));
    order_ = order;
    manager_ = std::make_unique<Manager>(registry_.All());
  }

  void Apply(const Input& input) {
    const std::string skill = kStarted[static_cast<std::size_t>(input.value) % kStarted.size()];
    switch (input.kind) {
      case 0:  // the clock may run back, and jump
        now_ += input.value == 119 ? Duration(std::chrono::hours(9))
                                   : Milliseconds(20 * input.value - 200);
        return Watched([&] { manager_->RunOnce(now_); });
      case 1:
        return Start(skill);
      case 2:
        return Watched([&] { (void)manager_->Cancel(skill, "random").ok(); });
      case 3:
        return Watched([&] { (void)manager_->CancelNow(skill, "random").ok(); });
      case 4:
        return Watched([&] { manager_->Pause(); });
      case 5:
        Forget(skill);
        return (void)manager_->Reset(skill).ok();
      case 6:
        return Watched([&] { manager_->CancelAllNow("random"); });
      default:
        Restore();
    }
  }

  // Steps until nothing can run any more.
  void RunOut() {
    // The skills of a composition may run one after the other, each with a cancellation.
    const auto steps = 4 * (kRunLimit + kCancelLimit) / std::chrono::seconds(1) + 16;
    for (std::int64_t i = 0; i < steps; ++i) {
      Watched([&] { manager_->RunOnce(now_ += std::chrono::seconds(1)); });
    }
    RC_ASSERT(!manager_->running());
  }

  void Check() {
    for (const Run* run : manager_->Runs()) CheckRun(*run);
  }

 private:
  // An ended run does not change by what `act` does.
  template <class Act>
  void Watched(Act&& act) {
    std::map<std::string, Feedback> ended;
    for (const Run* run : manager_->Runs()) {
      if (run->ended()) ended[run->name()] = run->feedback();
    }
    act();
    for (const auto& [name, feedback] : ended)
      RC_ASSERT(manager_->Find(name)->feedback() == feedback);
  }

  // The next run of the skill, and of those inside, begins with a progress of 0.
  void Forget(const std::string& skill) {
    progress_.erase(skill);
    if (skill != "all") return;
    for (const char* inside : {"c", "d", "e"}) progress_.erase(inside);
  }

  void Start(const std::string& skill) {
    const Run* run = manager_->Find(skill);
    const bool was_running = run != nullptr && run->running();
    const bool started = manager_->Start(skill).ok();
    RC_ASSERT(started != was_running);
    if (started) Forget(skill);
  }

  void Restore() {
    const Result<ManagerSnapshot> saved = manager_->Save();
    RC_ASSERT(saved.ok());
    auto other = std::make_unique<Manager>(registry_.All());
    RC_ASSERT(other->Restore(saved.value()).empty());
    RC_ASSERT(other->Save().value() == saved.value());
    manager_ = std::move(other);
  }

  void CheckRun(const Run& run) {
    const Feedback& feedback = run.feedback();
    RC_ASSERT(feedback.progress >= 0 && feedback.progress <= 100);
    RC_ASSERT((feedback.progress == 100) == (feedback.status == Status::kCompleted));
    RC_ASSERT((feedback.status == Status::kProcessing) == !run.ended());
    RC_ASSERT(run.retries() <= run.table().limits().retries);
    RC_ASSERT(feedback.state == run.Path());
    for (const Values::Named& detail : feedback.details) RC_ASSERT(!detail.name.empty());
    if (run.table().monotone()) {
      int& last = progress_[run.name()];
      RC_ASSERT(feedback.progress >= last);
      last = feedback.progress;
    }
    if (feedback.status == Status::kFailed) RC_ASSERT(run.errors().size() > 0U);
    CheckHistory(run);
    CheckSuccess(run);
  }

  static void CheckHistory(const Run& run) {
    for (std::size_t i = 0; i < run.history().size(); ++i) {
      const Change& change = run.history()[i];
      RC_ASSERT(!IsEnd(change.from));
      RC_ASSERT(change.to == kFailed || change.to == kCancelled ||
                run.table().Declared(change.from, change.to));
      if (i > 0) RC_ASSERT(change.from == run.history()[i - 1].to);
      if (i > 0) RC_ASSERT(change.at >= run.history()[i - 1].at);
    }
    if (!run.history().empty()) RC_ASSERT(run.history().back().to == run.state());
  }

  void CheckSuccess(const Run& run) {
    if (run.feedback().status != Status::kCompleted) return;
    const auto skill = std::ranges::find(kSkills, run.name());
    if (skill != kSkills.end()) {
      const Truth& truth = truths_[static_cast<std::size_t>(skill - kSkills.begin())];
      RC_ASSERT(truth.succeeds);
      return;
    }
    std::size_t completed = 0;
    for (const Run* inside : run.inside()) {
      CheckRun(*inside);
      RC_ASSERT(inside->ended());
      completed += inside->feedback().status == Status::kCompleted ? 1 : 0;
    }
    RC_ASSERT(completed == run.inside().size() ||
              (order_ == Order::kFirstToFinish && completed > 0));
  }

  static constexpr std::array<std::string_view, 5> kSkillNames{"a", "b", "c", "d", "e"};
  const std::vector<std::string> kSkills{kSkillNames.begin(), kSkillNames.end()};
  const std::vector<std::string> kStarted{"a", "b", "all"};
  std::array<Truth, 5> truths_;
  Order order_ = Order::kInOrder;
  Registry registry_;
  std::unique_ptr<Manager> manager_;
  std::map<std::string, int> progress_;
  Time now_{};
};

RC_GTEST_PROP(RandomSkills, AlwaysEndAndNeverReportAFailureAsASuccess, (std::uint64_t seed)) {
  Robot robot(seed);
  for (const Input& input : AnyInput()) {
    robot.Apply(input);
    robot.Check();
  }
  robot.RunOut();
  robot.Check();
}

RC_GTEST_PROP(RandomSkills, CallOnEndExactlyOnceInEachRun, (std::uint64_t seed)) {
  Truth truth;
  Run run("a", std::make_unique<RandomSkill>(seed, truth));
  RC_ASSERT(run.Begin({}));
  for (const Input& input : AnyInput()) {
    RC_ASSERT(truth.ends == (run.ended() ? 1 : 0));
    if (input.kind == 2) run.Cancel("random");
    if (input.kind == 3) run.CancelNow("random");
    if (input.kind == 4) run.Pause();
    run.Step(Milliseconds(20 * input.value));
  }
  RC_ASSERT(truth.ends == (run.ended() ? 1 : 0));
}

RC_GTEST_PROP(RandomSkills, EndWithinTheirLimitOfACancellation, (std::uint64_t seed)) {
  Truth truth;
  Run run("a", std::make_unique<RandomSkill>(seed, truth));
  RC_ASSERT(run.Begin({}));
  const int before = *rc::gen::inRange(0, 40);
  for (int i = 0; i < before; ++i) run.Step(Milliseconds(100));
  const bool had_ended = run.ended();
  const Status status = run.feedback().status;
  run.Cancel("random");
  for (int i = 0; i < 22; ++i) run.Step(Milliseconds(100));
  RC_ASSERT(run.ended());
  RC_ASSERT((run.feedback().status == status || !had_ended));
  RC_ASSERT((run.feedback().status != Status::kCompleted || had_ended));
}

// Random texts of parameters are read as their kind, or refused.
RC_GTEST_PROP(AnyText, IsAValueOfItsKindOrRefused, (const std::string& text)) {
  for (int i = 0; i < 5; ++i) {
    const Kind kind = static_cast<Kind>(i);
    const Result<Value> value = Parse(kind, text);
    if (!value) continue;
    RC_ASSERT(KindOf(value.value()) == kind);
    RC_ASSERT(As(kind, value.value()).ok());
  }
}

}  // namespace musher::skill::property_test
