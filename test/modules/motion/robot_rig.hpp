#pragma once
// A robot of one real motion manager process, led by a controller in this process, with a board
// over DDS. In a domain of its own.

#include <gtest/gtest.h>
#include <sys/types.h>

#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "musher/controller/machine_controller.hpp"
#include "musher/messages/protocol/motion.hpp"
#include "musher/messages/protocol/motion_sequence.hpp"
#include "musher/test/modules/motion/topic_board.hpp"
#include "musher/test/support/process.hpp"
#include "musher/test/support/process_guard.hpp"
#include "musher/test/support/temp_folder.hpp"
#include "musher/transport/dds/node_thread.hpp"
#include "musher/transport/service.hpp"

namespace musher::motion::testing {

using musher::testing::Ended;
using musher::testing::Process;
using musher::testing::ProcessGuard;
using musher::testing::RunToEnd;

// Runs a program of this build with these arguments, to its end. Its errors are in its output.
Ended RunProgram(const std::string& name, const std::vector<std::string>& arguments);

// Writes the config of a robot of one motion manager, robot.toml, and its motion.toml. `board` are
// more keys of [board].
void WriteRobot(const std::string& folder, const std::string& board);

class RobotRig {
 public:
  // As WriteRobot().
  explicit RobotRig(const std::string& board = "");
  // Leads the machine to TearDown. A motion manager that hangs is killed.
  ~RobotRig();

  // Starts the board and leads the machine to Active. A failure says why.
  ::testing::AssertionResult BringUp();
  MachineController& controller() { return *controller_; }

  // Does something with the board, on its loop.
  void OnBoard(const std::function<void(TopicBoard&)>& work);
  // Waits until it holds; false when it does not.
  bool Await(const std::function<bool(const TopicBoard&)>& holds);

  // From now on the frames of streamers are received.
  void SubscribeToFrames();
  // Waits for a frame of this cmd_type.
  bool AwaitFrame(std::int32_t type);
  // Waits until the motion manager has printed this.
  bool AwaitLog(const std::string& text);

  // Its process; 0: none.
  pid_t ManagerPid() const;

  msg::MotionResultCmd::Response RequestMotion(std::int32_t id);
  msg::MotionSequenceShow::Response Show(const msg::MotionSequenceShow::Request& sequence);
  // The output of the motion manager.
  std::string Log() const;

 private:
  // The reply of a service of the motion manager.
  template <msg::Service S>
  Result<typename S::Response> Call(const std::string& service, const typename S::Request& request);

  TempFolder folder_;
  std::shared_ptr<transport::NodeThread> node_;
  std::unique_ptr<TopicBoard> board_;
  std::unique_ptr<transport::Subscription> frames_;
  std::set<std::int32_t> received_frames_;  // their cmd_types
  ProcessGuard guard_;
  std::optional<MachineController> controller_;  // last: it starts again what ends
};

}  // namespace musher::motion::testing
