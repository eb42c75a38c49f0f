// The engine of users' programs under injected faults: a program starts in Active only; it is
// stopped in all other states and by an emergency stop, and does not continue by itself.

#include <algorithm>
#include <fstream>

#include "musher/modules/vp_engine/engine.hpp"
#include "musher/test/modules/module_fault_test.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::vp_engine::engine_fault_test {

using Op = msg::ManageProgram;

// A user who runs a program that moves the robot for ever, and the robot.
class User {
 public:
  explicit User(transport::Node& desk)
      : client_(transport::MakeClient<Op>(desk, "vp/manage_program").value()),
        speech_(transport::MakeServer<msg::AudioTextPlay>(desk, "speech_text_play",
                                                          [this](const auto&, auto reply) {
                                                            ++spoken;
                                                            reply({0, 0});
                                                          })
                    .value()),
        ticker_(desk.loop().Every(Milliseconds(300), [this] {
          if (!runs) return;
          Op::Request request;
          request.operation = Op::kRun;
          request.program = "talk";
          client_->Call(request, Milliseconds(250), [](const auto&) {});
        })) {}

  bool runs = false;  // programs, at all times
  int spoken = 0;

 private:
  std::unique_ptr<transport::Client<Op>> client_;
  std::unique_ptr<transport::Server<msg::AudioTextPlay>> speech_;
  transport::LoopHandlePtr ticker_;
};

TEST(TheProgramEngine, RunsProgramsInActiveOnlyAndNeverInAnEmergencyUnderInjectedFaults) {
  const TempFolder folder;
  std::ofstream(folder / "talk.xml") << R"(<root BTCPP_format="4"><BehaviorTree ID="P">
    <Repeat num_cycles="-1"><Say text="here I am"/></Repeat></BehaviorTree></root>)";
  testing::ModuleFaultTest<Engine, User> test;
  test.scenarios = 50;
  test.make = [&] {
    return std::make_unique<Engine>("vp", VpConfig{.folder = folder.path(), .rate_hz = 20});
  };
  const auto sentences = [&test] {
    test.Pass(Milliseconds(150));  // what is under way
    test.peers->spoken = 0;
    test.Pass(Milliseconds(600));
    return test.peers->spoken;
  };
  int talked = 0;
  bool ran = false;  // by the user, in this Active
  test.always = [&](const Engine&, const ActuatorReport& report) {
    const bool permitted = report.state == kActive && report.emergency_stop == 0;
    ran = ran && permitted;
    EXPECT_TRUE(ran || sentences() == 0) << "a program continues by itself in " << report.state;
    test.peers->runs = true;
    const bool talks = sentences() > 0;
    test.peers->runs = false;
    ran = talks;
    if (talks) ++talked;
    EXPECT_TRUE(!talks || permitted) << "a program runs in " << report.state;
    test.Pass(Milliseconds(100));
  };
  test.after_emergency_stop = [&](const Engine&, const ActuatorReport&) {
    ran = false;
    EXPECT_EQ(sentences(), 0) << "during a stop";
  };
  test.Run();
  EXPECT_GT(talked, 50) << "or nothing has been tried";
}

}  // namespace musher::vp_engine::engine_fault_test
