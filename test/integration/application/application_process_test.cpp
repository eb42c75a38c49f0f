// An application in a process of its own: when it blocks, and when its machine has stopped by a
// fault.

#include <fstream>
#include <iterator>

#include "musher/test/application/show.hpp"
#include "musher/test/cli/program.hpp"
#include "musher/test/support/musher.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::application_process_test {

using cli::RunProgram;
using testing::Harness;
using ::testing::HasSubstr;

class AnApplicationsProcess : public ::testing::Test {
 protected:
  AnApplicationsProcess() {
    std::ofstream(harness_.path(), std::ios::app)
        << "command = [\"" + BinDir() + "/application_peer\"]\nrestart_delay_ms = 10\n";
    harness_.node().RunOnLoop([this] {
      order_ = transport::MakePublisher<msg::String>(harness_.node().node(), "order").value();
    });
  }
  ~AnApplicationsProcess() override {
    harness_.controller().Switch("TearDown");
    harness_.node().RunOnLoop([this] { order_.reset(); });
  }

  void Begin() {
    ASSERT_TRUE(harness_.controller().Init(harness_.path()).ok());
    ASSERT_TRUE(harness_.controller().AwaitSetUp().ok());
    ASSERT_TRUE(harness_.controller().Switch("SelfCheck").done());
    ASSERT_TRUE(harness_.controller().Switch("Active").done());
    EXPECT_THAT(RunProgram({"behavior", "show"}).out, HasSubstr("WORK"));
  }
  void Order(const std::string& order) {
    ASSERT_TRUE(testing::Until([this] {
      int readers = 0;
      harness_.node().RunOnLoop([&] { readers = order_->MatchedReaders(); });
      return readers > 0;
    }));
    harness_.node().RunOnLoop([&] { static_cast<void>(order_->Publish({order})); });
  }
  // It was restarted, and ticks. On a loaded host that may take more than one restart.
  static void AwaitBack() {
    testing::AwaitStatus([](const nlohmann::json& status) {
      const auto& show = status["actuators"]["show"];
      return show["restarts"] > 0 && show["restarting"] == false;
    });
    EXPECT_TRUE(testing::Until([] {
      return RunProgram({"--json", "behavior", "show"}).out.find(R"("ticking":true)") !=
             std::string::npos;
    })) << RunProgram({"history"}).out;
  }

  Harness harness_{"steady"};
  std::unique_ptr<transport::Publisher<msg::String>> order_;
};

TEST_F(AnApplicationsProcess, IsReportedAsHungWhenAStateBlocksAndIsRestarted) {
  Begin();
  Order("block");
  AwaitBack();
  EXPECT_THAT(RunProgram({"history"}).out, HasSubstr("hung"));
}

TEST_F(AnApplicationsProcess, ReportsWhyItsMachineStoppedAndIsRestarted) {
  Begin();
  Order("fail");
  AwaitBack();
  const auto history = RunProgram({"history"});
  EXPECT_THAT(history.out, HasSubstr("exit code 1")) << history.err;
  std::ifstream log(harness_.state_dir() + "/logs/show.log");
  EXPECT_THAT(std::string(std::istreambuf_iterator<char>(log), {}),
              HasSubstr("show: error: gives up: WORK: Run: the lamp is broken"));
}

}  // namespace musher::application_process_test
