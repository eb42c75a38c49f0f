// A host that is busy, with many clients: what a person needs there is not behind what others ask.

#include <sched.h>
#include <signal.h>

#include <algorithm>
#include <thread>

#include "musher/test/integration/cli/machine.hpp"

namespace musher::testing::load_test {

class BusyHost : public MachineByCli {
 protected:
  // One process that takes a whole CPU for each that there is, and twenty that ask for the status
  // without a pause.
  void Load() {
    cpu_set_t cpus;
    ASSERT_EQ(sched_getaffinity(0, sizeof(cpus), &cpus), 0);
    for (int i = 0; i < CPU_COUNT(&cpus); ++i) Add({"sh", "-c", "while :; do :; done"});
    const std::string asked = folder_ / "asked";
    for (int i = 0; i < kClients; ++i) {
      Add({"sh", "-c",
           "while " + BinDir() + "/musher status > /dev/null; do echo >> " + asked + "; done"});
    }
    ASSERT_TRUE(Until([&] { return std::ranges::count(ReadFile(asked), '\n') >= kClients; }))
        << "they do not ask";
  }

  static constexpr int kClients = 20;

 private:
  void Add(const std::vector<std::string>& argv) {
    load_.push_back(std::make_unique<Process>(argv));
  }

  std::vector<std::unique_ptr<Process>> load_;
};

// `estop` waited behind `status` for more than 90 s, and `down` found no controller.
TEST_F(BusyHost, IsStoppedAndTakenDownWhileTwentyClientsAskForTheStatus) {
  ASSERT_EQ(UpDetached().exit, 0);
  const pid_t controller = Status()["pid"];
  ASSERT_NO_FATAL_FAILURE(Load());
  const Ended estop = Musher({"estop", "--timeout", "120", "--json"});
  EXPECT_EQ(estop.exit, 0) << estop.err;
  const auto report = Json(estop.out);
  EXPECT_EQ(report["complete"], true);
  for (const char* actuator : {"legs", "voice", "eyes"}) {
    EXPECT_EQ(report["actuators"][actuator]["stopped"], true) << actuator;
  }
  const Ended down = Musher({"down"});
  EXPECT_EQ(down.exit, 0) << down.out << down.err;
  EXPECT_TRUE(AwaitEnd(controller));
}

}  // namespace musher::testing::load_test
