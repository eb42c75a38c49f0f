// Untrusted heartbeats: the monitor's computations with their times do not overflow, and it never
// waits for a time in the past.

#include "musher/lifecycle/health/health_monitor.hpp"

#include "musher/test/fuzz/untrusted.hpp"
#include "musher/test/lifecycle/coordination/harness.hpp"

namespace musher::fuzz {
namespace {

class Harness {
 public:
  explicit Harness(Input& input) : input_(input) {
    config_.transport = input_.Bool() ? TransportProfile::kLan : TransportProfile::kLocal;
    config_.actuators[0].checkpoint = Milliseconds(100);
  }

  void Run() {
    for (const ActuatorIndex i : config_.actuators.Indices()) {
      monitor_.Watch(i, 7, "here", i == 0, now_);
    }
    while (!input_.empty()) Next();
  }

 private:
  void Next() {
    const ActuatorIndex i(input_.Below(config_.actuators.size()));
    const Incarnation incarnation(input_.Bool() ? 7 : input_.Take<std::uint64_t>());
    switch (input_.Below(6)) {
      case 0:
        return Count(monitor_.OnSample(i, incarnation, now_));
      case 1:
      case 2: {
        const Heartbeat heartbeat{Duration(AnyTime(input_, now_)),
                                  transport::WorkFrom(input_.Byte()), AnyState(input_),
                                  Duration(AnyTime(input_, now_)), Duration(AnyTime(input_, now_))};
        return Count(monitor_.OnSample(i, incarnation, heartbeat, now_));
      }
      case 3:
        return Count(monitor_.Examined(i,
                                       {static_cast<Examination::Process>(input_.Below(4)),
                                        Milliseconds(input_.Take<std::uint16_t>())},
                                       now_));
      case 4:
        return monitor_.Watch(i, incarnation, std::string(input_.Text()), input_.Bool(), now_);
      default:
        now_ += Milliseconds(input_.Take<std::uint16_t>());
        Count(monitor_.TimePassed(now_));
        const auto deadline = monitor_.NextDeadline();
        Require(!deadline || *deadline > now_, "no deadline is in the past");
    }
  }

  void Count(const std::vector<HealthEvent>& events) const {
    Require(events.size() <= 2 * config_.actuators.size(),
            "at most two health events for each actuator");
  }

  Input& input_;
  MachineConfig config_ = testing::MachineOf(3);
  HealthMonitor monitor_{config_};
  Time now_ = Time(std::chrono::hours(1));
};

}  // namespace
}  // namespace musher::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  musher::fuzz::Input input(data, size);
  musher::fuzz::Harness(input).Run();
  return 0;
}
