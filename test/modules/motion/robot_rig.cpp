#include "musher/test/modules/motion/robot_rig.hpp"

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <future>
#include <iterator>

#include "musher/test/modules/motion/harness.hpp"
#include "musher/test/support/domain.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::motion::testing {
namespace {

constexpr const char* kStates =
    R"(["SetUp", "TearDown", "SelfCheck", "Active", "DeActive", "Protected", "LowPower", "OTA", "Error"])";

// The board is a thread of a test: on a busy host its reply may take longer than that of a board.
constexpr const char* kLongTimeouts = "\n[board]\nsilent_ms = 5000\nfeedback_ms = 2000\n";

void Write(const std::string& file, const std::string& text) {
  std::ofstream(file) << text;
}

// The process of this name among those that `parent` and its children have started; 0: none.
pid_t DescendantNamed(const std::string& name, pid_t parent) {
  std::error_code error;
  const std::string tasks = "/proc/" + std::to_string(parent) + "/task";
  for (const auto& task : std::filesystem::directory_iterator(tasks, error)) {
    std::ifstream children(task.path() / "children");
    for (pid_t child = 0; children >> child;) {
      std::string its_name;
      std::getline(std::ifstream("/proc/" + std::to_string(child) + "/comm"), its_name);
      if (its_name == name) return child;
      if (const pid_t deeper = DescendantNamed(name, child); deeper != 0) return deeper;
    }
  }
  return 0;
}

}  // namespace

Ended RunProgram(const std::string& name, const std::vector<std::string>& arguments) {
  std::string line = "exec " + BinDir() + "/" + name;
  for (const std::string& argument : arguments) line += " '" + argument + "'";
  return RunToEnd({"sh", "-c", line + " 2>&1"});
}

void WriteRobot(const std::string& folder, const std::string& board) {
  Write(folder + "/motion.toml",
        "motions = \"" + SourceDir() + "/config/motion/motions.toml\"\n" + kLongTimeouts + board);
  const std::string states(kStates);
  Write(folder + "/robot.toml",
        "[controller]\nactuators = [\"motion_manager\"]\nstates = " + states +
            "\ndefault_time = 20000\ndefault_state = \"Uninitialized\"\n"
            "state_dir = \"state\"\n[actuator.motion_manager]\nstates = " +
            states +
            "\ntimes = [20000, 20000, 20000, 20000, 20000, 20000, 20000, "
            "20000, 20000]\ncritical = true\ncommand = [\"" +
            BinDir() +
            "/musher-motion-manager\", \"motion.toml\"]\ncwd = \".\"\n"
            "[capability.walk]\nactuators = [\"motion_manager\"]\nstates = "
            "[\"Active\", \"Protected\"]\n");
}

RobotRig::RobotRig(const std::string& board) {
  setenv("ROS_DOMAIN_ID", std::to_string(transport::TestDomain()).c_str(), 1);
  WriteRobot(folder_.path(), board);
  node_ = transport::NodeThread::Start().value();
  controller_.emplace();
}

RobotRig::~RobotRig() {
  controller_->Switch("TearDown");
  node_->RunOnLoop([this] {
    frames_.reset();
    board_.reset();
  });
}

::testing::AssertionResult RobotRig::BringUp() {
  node_->RunOnLoop([this] {
    board_ = std::make_unique<TopicBoard>(node_->node());
    const Motion& lying = *TheTable().Find(kGetDown);
    board_->board.report.mode = lying.mode;
    board_->board.report.gait = lying.gait;
    board_->board.report.bar = 100;
  });
  if (const auto begun = controller_->Init(folder_ / "robot.toml"); !begun) {
    return ::testing::AssertionFailure() << begun.error().message;
  }
  if (const auto there = controller_->AwaitSetUp(); !there) {
    return ::testing::AssertionFailure() << there.error().message << "\n" << Log();
  }
  for (const char* target : {"SelfCheck", "Active"}) {
    const SwitchResult result = controller_->Switch(State(target));
    if (result.done()) continue;
    return ::testing::AssertionFailure()
           << "the switch to " << target << " is " << OutcomeName(result.outcome) << ": "
           << result.reason << "\n"
           << Log();
  }
  return ::testing::AssertionSuccess();
}

void RobotRig::OnBoard(const std::function<void(TopicBoard&)>& work) {
  node_->RunOnLoop([&] { work(*board_); });
}

bool RobotRig::Await(const std::function<bool(const TopicBoard&)>& holds) {
  std::promise<void> held;
  transport::LoopHandlePtr look;
  node_->RunOnLoop([&] {
    look = node_->loop().Every(Milliseconds(2), [&] {
      if (!holds(*board_)) return;
      held.set_value();
      look.reset();
    });
  });
  const bool done =
      held.get_future().wait_for(std::chrono::seconds(120)) == std::future_status::ready;
  node_->RunOnLoop([&] { look.reset(); });
  return done;
}

void RobotRig::SubscribeToFrames() {
  node_->RunOnLoop([this] {
    frames_ = transport::MakeSubscription<msg::MotionServoCmd>(
                  node_->node(), "motion_servo_cmd",
                  [this](const msg::MotionServoCmd& frame, const transport::SampleInfo&) {
                    received_frames_.insert(frame.cmd_type);
                  },
                  transport::kSystemDefaultQos)
                  .value();
  });
}

bool RobotRig::AwaitFrame(std::int32_t type) {
  return Await([&](const TopicBoard&) { return received_frames_.contains(type); });
}

bool RobotRig::AwaitLog(const std::string& text) {
  return Await([&](const TopicBoard&) { return Log().find(text) != std::string::npos; });
}

template <msg::Service S>
Result<typename S::Response> RobotRig::Call(const std::string& service,
                                            const typename S::Request& request) {
  std::promise<Result<typename S::Response>> reply;
  std::unique_ptr<transport::Client<S>> client;
  node_->RunOnLoop([&] {
    client = transport::MakeClient<S>(node_->node(), service).value();
    client->Call(request, std::chrono::seconds(120),
                 [&](auto result) { reply.set_value(std::move(result)); });
  });
  auto answer = reply.get_future().get();
  node_->RunOnLoop([&] { client.reset(); });
  return answer;
}

msg::MotionResultCmd::Response RobotRig::RequestMotion(std::int32_t id) {
  msg::MotionResultCmd::Request request;
  request.motion_id = id;
  const auto answer = Call<msg::MotionResultCmd>("motion_result_cmd", request);
  if (answer) return answer.value();
  return {id, false, answer.error().code};
}

msg::MotionSequenceShow::Response RobotRig::Show(const msg::MotionSequenceShow::Request& sequence) {
  const auto answer = Call<msg::MotionSequenceShow>("motion_sequence_cmd", sequence);
  if (answer) return answer.value();
  return {false, answer.error().code, answer.error().message, sequence.motion_id};
}

pid_t RobotRig::ManagerPid() const {
  return DescendantNamed("musher-motion-m", getpid());
}

std::string RobotRig::Log() const {
  std::string text;
  std::error_code error;
  for (const auto& entry :
       std::filesystem::recursive_directory_iterator(folder_ / "state", error)) {
    if (entry.path().filename().string().find("motion_manager") == std::string::npos) continue;
    if (!entry.is_regular_file()) continue;
    std::ifstream stream(entry.path());
    text.append(std::istreambuf_iterator<char>(stream), {});
  }
  return text;
}

}  // namespace musher::motion::testing
