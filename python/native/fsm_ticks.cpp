// Python: the ticks of an application, on the clock of its machine.

#include <optional>
#include <utility>

#include "musher/application/ticks.hpp"
#include "musher/python/native/fsm_machine.hpp"
#include "musher/python/native/node.hpp"
#include "musher/python/native/py_actuator.hpp"

namespace musher::python {
namespace {

// The loop puts each tick into the node's mailbox, from which the node's Python thread takes it; a
// tick that was not taken yet gets the new time. In a fault-injection test nothing ticks, and the
// time is 0.
class FsmTicks {
 public:
  // In SetUp.
  FsmTicks(const ActuatorHandle& handle, MailboxPtr mailbox, std::int64_t key)
      : handle_(handle), mailbox_(std::move(mailbox)), key_(key) {
    PyActuator& actuator = handle_.Get();
    Check(WithoutGil([&] {
      return actuator.OpenEndpoints([this](transport::Endpoints& topics) { ticks_.Open(topics); });
    }));
  }

  void Start(double rate_hz) {
    Run([&] {
      ticks_.Start(rate_hz, [ticks = ticks_, mailbox = mailbox_, key = key_] {
        Item item;
        item.key = key;
        item.token = NsOf(ticks.Now());
        mailbox->PushLatest(std::move(item));
      });
    });
  }
  void Stop() {
    Run([this] { ticks_.Stop(); });
  }
  // ns, on the machine's clock.
  std::uint64_t Now() {
    std::uint64_t now = 0;
    Run([&] { now = NsOf(ticks_.Now()); });
    return now;
  }
  std::pair<std::int32_t, std::uint32_t> Stamp() {
    msg::Stamp stamp;
    Run([&] { stamp = ticks_.Stamp(); });
    return {stamp.sec, stamp.nanosec};
  }
  // For how many seconds this process could not run since the last call, if it could not.
  std::optional<double> TakeBreak() {
    std::optional<Duration> could_not_run;
    Run([&] { could_not_run = ticks_.TakeBreak(); });
    if (!could_not_run) return std::nullopt;
    return ToSeconds(*could_not_run);
  }

 private:
  template <class Work>
  void Run(const Work& work) {
    PyActuator& actuator = handle_.Get();
    WithoutGil([&] { actuator.RunOnLoop(work); });
  }
  static std::uint64_t NsOf(Time time) {
    return static_cast<std::uint64_t>(Duration(time.time_since_epoch()).count());
  }

  const ActuatorHandle& handle_;
  const MailboxPtr mailbox_;
  const std::int64_t key_;
  Ticks ticks_;
};

}  // namespace

void AddFsmTicks(py::module_& native) {
  py::class_<FsmTicks>(native, "FsmTicks")
      .def(py::init<const ActuatorHandle&, MailboxPtr, std::int64_t>(), py::keep_alive<1, 2>())
      .def("start", &FsmTicks::Start)
      .def("stop", &FsmTicks::Stop)
      .def("now_ns", &FsmTicks::Now)
      .def("stamp", &FsmTicks::Stamp)
      .def("take_break_s", &FsmTicks::TakeBreak);
}

}  // namespace musher::python
