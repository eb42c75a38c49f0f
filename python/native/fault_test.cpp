#include "musher/python/native/fault_test.hpp"

#include <deque>
#include <map>
#include <mutex>

#include "musher/base/code.hpp"
#include "musher/python/native/py_actuator.hpp"
#include "musher/simulation/fault_test.hpp"

namespace musher::python {
namespace {

using simulation::FaultTestFailure;

// What the Python layer (musher/testing.py) passes. `make` returns an Actuator; with
// `fails_by_itself` it gets the Faults. The checks get the actuator and the report, and return a
// failure as text, or None.
struct Options {
  std::string config_file;
  std::string config_text;
  py::function make;
  bool fails_by_itself = false;
  py::object before_scenario;
  py::object always;
  py::object after_emergency_stop;
  std::optional<int> battery;
  double real_time_limit_s = 10;
};

class Test {
 public:
  explicit Test(Options options) : options_(std::move(options)) {}

  // (seed, injected events, what, timeline, reproduced) of the first failing scenario; None: none
  // fails.
  py::object Find(std::uint64_t first, std::uint64_t count) {
    return Run([&](simulation::FaultTest& test) -> Result<std::optional<FaultTestFailure>> {
      return test.Find(first, count);
    });
  }
  py::object RunOne(std::uint64_t seed, const std::optional<std::vector<std::size_t>>& only) {
    return Run([&](simulation::FaultTest& test) { return test.Run({seed, only}); });
  }
  const std::string& timeline() const { return timeline_; }
  std::map<std::string, std::uint64_t> Counts() const {
    return {{"scenarios", counts_.scenarios},
            {"processes", counts_.processes},
            {"callbacks", counts_.callbacks},
            {"failed", counts_.failed},
            {"repeated", counts_.repeated},
            {"stop_requested", counts_.stop_requested},
            {"killed", counts_.killed},
            {"stops_during_callback", counts_.stops_during_callback},
            {"emergency_stops", counts_.emergency_stops},
            {"torn_down", counts_.torn_down}};
  }

 private:
  template <class Work>
  py::object Run(const Work& work) {
    simulation::FaultTestSetup setup;
    setup.config_file = options_.config_file;
    setup.config_text = options_.config_text;
    setup.fails_by_itself = options_.fails_by_itself;
    setup.real_time_limit =
        std::chrono::milliseconds(static_cast<std::int64_t>(options_.real_time_limit_s * 1000));
    setup.battery = options_.battery;
    setup.make = [this](simulation::Faults& faults) { return MakeGuarded(faults); };
    setup.check = [this](const MachineActuator& actuator, const ActuatorReport& report) {
      CheckProperty(options_.always, actuator, report);
    };
    setup.check_stop = [this](const MachineActuator& actuator, const ActuatorReport& report) {
      CheckProperty(options_.after_emergency_stop, actuator, report);
    };
    setup.next_failure = [this] { return NextFailure(); };
    setup.before_scenario = [this] {
      const TakenGil gil;
      BeforeScenario();
    };
    auto made = simulation::FaultTest::Make(std::move(setup));
    if (fatal_) std::rethrow_exception(std::exchange(fatal_, nullptr));
    if (!made) Raise("ConfigError", made.error());
    simulation::FaultTest& test = made.value();
    const auto result = WithoutGil([&] { return work(test); });
    timeline_ = test.timeline();
    counts_ = test.counts();
    if (fatal_) std::rethrow_exception(std::exchange(fatal_, nullptr));
    if (!result) Raise("ConfigError", result.error());
    if (!result.value()) return py::none();
    const FaultTestFailure& failure = *result.value();
    return py::make_tuple(failure.id.seed, failure.id.only, failure.what, failure.timeline,
                          failure.reproduced);
  }

  // With the GIL.
  std::unique_ptr<PyActuator> Make(simulation::Faults& faults) {
    const py::object made =
        options_.fails_by_itself
            ? options_.make(py::cast(&faults, py::return_value_policy::reference))
            : options_.make();
    const py::object handle = made.attr("_handle");
    return handle.cast<ActuatorHandle&>().Get().Release();
  }
  std::unique_ptr<MachineActuator> MakeGuarded(simulation::Faults& faults) {
    const TakenGil gil;
    try {
      return Make(faults);
    } catch (...) {  // the test ends with it: an actuator that cannot be made was made before
      if (!fatal_) fatal_ = std::current_exception();
      return std::make_unique<MachineActuator>("not_made");
    }
  }
  void BeforeScenario() {
    if (!options_.before_scenario.is_none()) options_.before_scenario();
  }

  void CheckProperty(const py::object& property, const MachineActuator& actuator,
                     const ActuatorReport& report) {
    const TakenGil gil;
    if (property.is_none()) return;
    const auto* ours = dynamic_cast<const PyActuator*>(&actuator);
    if (ours == nullptr) return;
    try {
      const py::object failure = property(ours->Self(), py::cast(report));
      if (!failure.is_none()) failures_.push_back(failure.cast<std::string>());
    } catch (const std::exception& e) {
      failures_.emplace_back(e.what());
    }
  }
  std::string NextFailure() {
    if (failures_.empty()) return {};
    std::string next = std::move(failures_.front());
    failures_.pop_front();
    return next;
  }

  const Options options_;
  std::deque<std::string> failures_;  // used on the thread of the test
  std::exception_ptr fatal_;
  std::string timeline_;
  simulation::FaultTestCounts counts_;
};

}  // namespace

void AddFaultTest(py::module_& native) {
  py::class_<ActuatorReport>(native, "Report")
      .def_readonly("state", &ActuatorReport::state)
      .def_readonly("target", &ActuatorReport::target)
      .def_property_readonly(
          "emergency_stop", [](const ActuatorReport& report) { return report.emergency_stop != 0; })
      .def_readonly("held_by_stop", &ActuatorReport::held_by_stop)
      .def_readonly("degraded_reason", &ActuatorReport::degraded_reason);
  py::class_<simulation::Faults>(native, "Faults")
      .def("should_fail", &simulation::Faults::ShouldFail)
      .def("random", &simulation::Faults::Random);
  py::class_<Test>(native, "FaultTest")
      .def(py::init([](std::string config_file, std::string config_text, py::function make,
                       bool fails_by_itself, py::object before_scenario, py::object always,
                       py::object after_emergency_stop, std::optional<int> battery,
                       double real_time_limit_s) {
        return std::make_unique<Test>(
            Options{std::move(config_file), std::move(config_text), std::move(make),
                    fails_by_itself, std::move(before_scenario), std::move(always),
                    std::move(after_emergency_stop), battery, real_time_limit_s});
      }))
      .def("find", &Test::Find)
      .def("run_one", &Test::RunOne)
      .def("timeline", &Test::timeline)
      .def("counts", &Test::Counts);
}

}  // namespace musher::python
