#pragma once
// A small application in one process with its controller, on a /clock that the test advances.

#include <gmock/gmock.h>

#include <atomic>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "musher/application/fsm_actuator.hpp"
#include "musher/controller/machine_controller.hpp"
#include "musher/messages/musher_msgs/actuator_status.hpp"
#include "musher/messages/musher_msgs/heartbeats.hpp"
#include "musher/messages/rosgraph_msgs/clock.hpp"
#include "musher/messages/stamp.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/test/application/inspected.hpp"
#include "musher/test/support/domain.hpp"
#include "musher/test/support/temp_folder.hpp"
#include "musher/test/support/wait.hpp"
#include "musher/transport/clock.hpp"
#include "musher/transport/endpoints.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::testing {

// The script of the application and its log; accessed on the loop, or by RunOnLoop().
struct ShowData {
  std::vector<std::string> log;
  std::map<std::string, std::string> throws;  // the exception of a hook or of a state's function
  std::map<std::string, int> runs;            // of each state
  bool unsafe = false;
  bool safe_state = true;
  bool left_early = false;  // it stops its machine itself

  void Do(const std::string& what) {
    log.push_back(what);
    if (const auto found = throws.find(what); found != throws.end()) {
      throw std::runtime_error(found->second);
    }
  }
};

// Greets for 100 ms, then plays until the command "again" comes.
class Scene : public fsm::State {
 public:
  Scene(ShowData& data, std::string name, std::string next, Duration time)
      : data_(data), name_(std::move(name)), next_name_(std::move(next)), time_(time) {}

  void Declare(fsm::Transitions& transitions) override {
    next_ = transitions.To(next_name_, "its time is over");
    again_ = transitions.On("again");
  }
  void OnEnter(const fsm::Tick&) override { data_.Do(name_ + " enters"); }
  void Run(const fsm::Tick&) override {
    ++data_.runs[name_];
    if (data_.throws.contains(name_ + " runs")) data_.Do(name_ + " runs");
  }
  fsm::Next CheckTransition(const fsm::Tick& tick) override {
    const bool over = tick.elapsed >= time_ || tick.command == again_;
    return over ? fsm::Next::To(next_) : fsm::Next::Stay();
  }
  void OnExit(const fsm::Tick&) override { data_.Do(name_ + " leaves"); }

 private:
  ShowData& data_;
  const std::string name_;
  const std::string next_name_;
  const Duration time_;
  fsm::StateId next_ = fsm::kNoState;
  fsm::EventId again_ = fsm::kNoEvent;
};

class Show : public FsmActuator, public Inspected<Show> {
 public:
  explicit Show(Options options = {.rate_hz = 50}) : FsmActuator("show", std::move(options)) {}

  ShowData& data() { return data_; }  // before Start(), or by RunOnLoop()
  std::string Path() {
    return Of([](Show& show) { return show.machine().Path(); });
  }
  std::uint64_t Ticks() {
    return Of([](Show& show) { return show.machine().ticks(); });
  }
  std::vector<std::string> TakeLog() {
    return Of([](Show& show) { return std::exchange(show.data_.log, {}); });
  }

  using FsmActuator::machine;
  using FsmActuator::Now;
  using FsmActuator::Send;
  using FsmActuator::Stamp;
  using FsmActuator::ticking;

 private:
  Result<> BuildMachine(fsm::Machine& machine) override {
    if (data_.throws.contains("builds")) data_.Do("builds");
    const Duration for_ever = std::chrono::hours(1'000);
    machine.AddEvent("again");
    machine.Add("GREET", std::make_unique<Scene>(data_, "GREET", "PLAY", Milliseconds(100)));
    machine.Add("PLAY", std::make_unique<Scene>(data_, "PLAY", "GREET", for_ever));
    if (data_.safe_state) {
      machine.Add("STOP", std::make_unique<Scene>(data_, "STOP", "GREET", Milliseconds(100)),
                  fsm::Role::kSafe);
      machine.AddSafetyCheck("too close", [this](const fsm::Tick&) { return !data_.unsafe; });
    }
    return machine.Build("GREET");
  }
  void OpenTopics(transport::Endpoints& topics) override {
    topics.Subscribe<msg::String>("show/force", [this](const msg::String& state) {
      static_cast<void>(machine().Force(state.data));
    });
  }
  void BeforeTick(Time) override {
    if (data_.throws.contains("before")) data_.Do("before");
    if (data_.left_early) static_cast<void>(machine().Stop());
  }
  void AfterTick(Time) override {
    if (data_.throws.contains("after")) data_.Do("after");
  }
  void OnPause() override { data_.Do("pauses"); }
  void OnResume() override { data_.Do("resumes"); }
  Result<> SelfCheck() override {
    if (!data_.unsafe) return Ok();
    return Error{5109, "no loudspeaker"};
  }

  ShowData data_;
};

// The controller of a machine with the show, or another actuator, as its only one, and /clock.
class Harness {
 public:
  explicit Harness(const std::string& clock = "topic", const std::string& actuator = "show") {
    setenv("ROS_DOMAIN_ID", std::to_string(transport::TestDomain()).c_str(), 1);
    const std::string states =
        R"(["SetUp", "TearDown", "SelfCheck", "Active", "DeActive", "Protected", "LowPower", "OTA",
            "Error"])";
    std::ofstream(path())
        << "[controller]\nactuators = [\"" << actuator << "\"]\nstates = " << states
        << "\ndefault_time = 5000\ndefault_state = \"Uninitialized\""
        << "\nclock = \"" << clock << "\"\nstate_dir = \"" << folder_ / "state"
        << "\"\n[actuator." << actuator << "]\nstates = " << states
        << "\ntimes = [60000, 20000, 20000, 20000, 20000, 20000, 20000, 20000, 20000]\n"
        << "checkpoint_ms = 5000\n";
    node_ = transport::NodeThread::Start().value();
    node_->RunOnLoop([this] {
      world_ = transport::MakePublisher<msg::Clock>(node_->node(), "clock", transport::kClockQos)
                   .value();
    });
  }
  ~Harness() {
    node_->RunOnLoop([this] {
      world_.reset();
      button_.reset();
    });
  }
  Harness(const Harness&) = delete;
  Harness& operator=(const Harness&) = delete;

  std::string path() const { return folder_ / "robot.toml"; }
  std::string state_dir() const { return folder_ / "state"; }
  transport::NodeThread& node() { return *node_; }
  MachineController& controller() { return controller_; }

  // The show, or another actuator with its name, is set up and has received /clock. `node`: its
  // own.
  template <class Application>
  void Open(Application& show, std::shared_ptr<transport::NodeThread> node = nullptr) {
    const Result<> ready = show.Init(path(), std::move(node));
    ASSERT_TRUE(ready) << ready.error().message;
    const Result<> started = show.Start();
    ASSERT_TRUE(started) << started.error().message;
    ASSERT_TRUE(controller_.Init(path()).ok());
    ASSERT_TRUE(controller_.AwaitSetUp().ok());
    Advance(show, Milliseconds(20));
  }
  // Advances /clock, and waits until the show has received it.
  template <class Application>
  void Advance(Application& show, Duration step) {
    now_ += step;
    const Time there = Time{} + now_;
    ASSERT_TRUE(Until([&] {
      if (show.Of([](auto& s) { return s.Now(); }) == there) return true;
      node_->RunOnLoop([this] { static_cast<void>(world_->Publish({msg::ToStamp(now_)})); });
      return false;
    }));
  }
  void PressEmergencyStop() {
    node_->RunOnLoop([this] {
      button_ = transport::MakePublisher<msg::EmergencyStop>(
                    node_->node(), transport::EmergencyStopTopic(""), transport::kLatchedQos)
                    .value();
      static_cast<void>(button_->Publish({7, true, "a test", ""}));
    });
  }
  // Whether a status with the stop says so: "" where it is confirmed.
  bool AwaitStop(const std::string& trouble) {
    msg::ActuatorStatus last;
    std::unique_ptr<transport::Subscription> statuses;
    node_->RunOnLoop([&] {
      statuses = transport::MakeSubscription<msg::ActuatorStatus>(
                     node_->node(), transport::ActuatorStatusTopic(""),
                     [&](const msg::ActuatorStatus& status, const auto&) { last = status; },
                     transport::kLatchedFromManyQos)
                     .value();
    });
    const bool found = Until([&] {
      bool says = false;
      node_->RunOnLoop([&] {
        const bool has = last.stop_trouble.find(trouble) != std::string::npos;
        says = last.emergency_stop == 7 && has && trouble.empty() == last.stop_trouble.empty();
      });
      return says;
    });
    node_->RunOnLoop([&] { statuses.reset(); });
    return found;
  }
  // This many ticks of 20 ms.
  template <class Application>
  void Tick(Application& show, int count) {
    for (int i = 0; i < count; ++i) Advance(show, Milliseconds(20));
  }

 private:
  const TempFolder folder_;
  std::shared_ptr<transport::NodeThread> node_;
  std::unique_ptr<transport::Publisher<msg::Clock>> world_;
  std::unique_ptr<transport::Publisher<msg::EmergencyStop>> button_;
  Duration now_ = std::chrono::seconds(1'000);
  MachineController controller_;
};

class WithHarness : public ::testing::Test {
 protected:
  // In Active.
  void Begin(ActuatorRunner<Show>& show) {
    harness_.Open(show);
    ASSERT_TRUE(harness_.controller().Switch("SelfCheck").done());
    ASSERT_TRUE(harness_.controller().Switch("Active").done());
  }

  Harness harness_;
};

}  // namespace musher::testing
