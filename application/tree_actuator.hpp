#pragma once
// The base class of an application that is a behaviour tree (behavior/tree): an actuator that ticks
// the tree while the robot is Active.
//
//   class Patrol : public musher::TreeActuator {
//    public:
//     Patrol() : TreeActuator("patrol", {.rate_hz = 50, .file = "patrol.xml"}) {}
//
//    private:
//     Result<> RegisterNodes(tree::Factory& factory) override {
//       return factory.Add<Move>("Move", robot_);
//     }
//     void OpenTopics(transport::Endpoints& topics) override { ... of the robot ... }
//     void AfterTick(Time now, tree::Status status) override { ... publish what the nodes want ...
//     } void OnPause() override { ... bring the outputs to neutral ... }
//
//     Robot robot_;
//   };
//
// clang-format off
//   robot          tree
//   SetUp          is built; topics are opened
//   SelfCheck      SelfCheck() is called
//   Active         is ticked, from its root on, once it was commanded to begin (Options::begin)
//   all others     its running nodes are halted; OnPause(). Its blackboard is kept (or made new for
//                  the next Active: Options::resume)
//   an emergency stop: the same at once, until the stop is released and Active is set again, also
//                  where the robot is still in Active
//                  (during SetUp nothing runs yet: there is nothing to halt)
//   its process could not run for more than a minute: its running nodes are halted; OnBreak(). It
//                  rests until a command to begin (with Begin::kAtActive: begins at its root)
// clang-format on
//
// A node may ask for a tick at once, by its WakeUp, when what it awaits has come; the ticks of the
// rate go on as before.
//
// Without a command to begin since the process began, the tree rests in Active: a restarted process
// moves nothing (begin.hpp). The command is START on the service `<actuator>/send_command`
// (`musher behavior NAME --tree --send START`), Load() or Restart(). A tree that is under way
// refuses START: one that is sent twice does not send the robot back to the beginning.
//
// The end of the tree: after SUCCESS, FAILURE or SKIPPED it rests until Restart(), Load() or Halt()
// (or begins again with the next tick: Options::restart_after_end). It also rests over a pause: a
// mission that has ended does not begin again because the robot has slept. Hooks are called while
// it rests.
//
// A tick that throws: the nodes that run are halted, last_fault() is the reason with the place and
// the path of the node, and that is an end with FAILURE. `musher status` shows the actuator as
// degraded with it until Restart(), Load() or the next self-check. Where a node throws in its halt,
// by a pause, a stop or a clock that jumps back, the tree rests then, and the emergency stop is not
// confirmed: what the node has not stopped may still move. The process goes on, because the
// next plan, another tree or a Restart() may be possible. So does an exception of BeforeTick() (the
// tree is not ticked then) or AfterTick(). A node that blocks blocks the loop: with checkpoint_ms
// in the config the actuator is then reported as hung.
//
// Interfaces: services `<actuator>/get_tree` (musher_msgs/GetTree) and `<actuator>/send_command`
// (musher_msgs/SendCommand; START is its only command), and topic `<actuator>/tree_state`
// (musher_msgs/TreeState, latched): at most 20 a second while a program is subscribed, and at each
// start, pause and end, and whenever another tree is loaded.
//
// With Options::record the changes of its nodes and entries are recorded, from SetUp on: see
// tree_recording.hpp.
//
// In a fault-injection test (simulation/actuator_fault_test.hpp) there is neither transport nor
// clock: the tree is built and halted, and is not ticked.
//
// Threads: the tree, the hooks and the handlers of topics run on the loop, one at a time, so they
// share data without locks. RegisterNodes(), LoadTree(), SelfCheck() and, without an outer_board,
// the first FillBlackboard() run on the actuator's worker. Times are the machine's, see
// [controller] clock: `now` of a node is Now(). When that clock jumps back, because a simulated
// world was restarted, the tree is halted and begins at its root.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "musher/actuator/machine_actuator.hpp"
#include "musher/application/begin.hpp"
#include "musher/application/tree_recording.hpp"
#include "musher/application/tree_report.hpp"
#include "musher/behavior/tree/tree.hpp"
#include "musher/messages/builtin_interfaces/time.hpp"

namespace musher {

class TreeActuator : public MachineActuator {
 public:
  enum class Resume : std::uint8_t {
    kKeepBlackboard,
    kNewBlackboard  // the tree is built again at each change to Active. An end does not rest then;
                    // a Halt() and a fault do
  };
  struct Options {
    double rate_hz = 100;  // of ticks; more than 0
    Begin begin = Begin::kOnCommand;
    Resume resume = Resume::kKeepBlackboard;
    std::size_t history = 256;       // changes that are kept
    bool restart_after_end = false;  // the next tick after an end begins at the root
    std::string file{};              // XML, for LoadTree()
    std::string tree{};              // its id; empty: main_tree_to_execute, or the only one
    TreeRecordingOptions record{};   // what `musher tree replay` shows; default: none
    // Around the board of each tree: its keys "@key". Keeps its values when another tree is loaded.
    // Actuators that share it must share their node, too: its loop builds and ticks their trees.
    std::shared_ptr<tree::Board> outer_board{};
  };
  // Keys of the blackboard of the main tree with their values as texts.
  using Entries = std::vector<std::pair<std::string, std::string>>;

  explicit TreeActuator(const std::string& actuator_name)
      : TreeActuator(actuator_name, Options{}) {}
  TreeActuator(const std::string& actuator_name, Options options);
  ~TreeActuator() override;

 protected:
  // In SetUp. A failure fails SetUp. What the nodes refer to must live as long as this object.
  virtual Result<> RegisterNodes(tree::Factory& factory) = 0;
  // After that: the tree; a document without trees is none. The message of the error has all errors
  // of the file, a line each. This one reads Options::file.
  virtual Result<tree::Document> LoadTree();
  // A tree was built, by SetUp, by Load() or for Resume::kNewBlackboard: its first entries. Those
  // of Load() are set after it. A failure is one of SetUp, of Load() or of the switch to Active.
  virtual Result<> FillBlackboard(tree::Board& /*board*/) { return Ok(); }
  // After that, on the loop: topics and services. Not called in a fault-injection test.
  virtual void OpenTopics(transport::Endpoints& /*topics*/) {}
  // Whether its dependencies are available. May block.
  virtual Result<> SelfCheck() { return Ok(); }

  // Before and after each tick, and at the same rate while the tree rests. `status`: of this tick;
  // IDLE where the tree was not ticked because it rests or there is none. Both may Load(), Halt()
  // and Restart().
  virtual void BeforeTick(Time /*now*/) {}
  virtual void AfterTick(Time /*now*/, tree::Status /*status*/) {}
  // The tree is not ticked from now on: the robot is not Active, or an emergency stop was engaged.
  // Its nodes are already halted. Bring the outputs to neutral; must return at once and be
  // idempotent. An exception is logged, and shown in the status until a further pause succeeds.
  virtual void OnPause() {}
  // The robot goes to Active; called before the first tick. An exception fails the switch to Active
  // with its text, after OnPause().
  virtual void OnResume() {}
  // The process could not run for more than a minute: what ran does not go on by itself. The nodes
  // are already halted, and the tree rests, except with Begin::kAtActive. As OnPause(), which this
  // one calls.
  virtual void OnBreak() { OnPause(); }
  // START was sent, in Active. An error refuses it. This one is Restart(), unless the tree is under
  // way.
  virtual Result<> OnStartCommand();

  // All of these on the loop only, from SetUp on.
  bool has_tree() const;
  tree::Tree& tree();  // there must be one
  const tree::Factory& factory() const;
  // Replaces the tree, and begins with it at the next tick of Active; the old one is halted first.
  // Keeps the old one, and what the outer_board has, and fails, with all errors a line each, where
  // the document or an entry is wrong. Fails also where a node of the old one throws in its halt:
  // the old one rests then, with that fault; and within a tick, in the code of a node. `main`: as
  // Options::tree.
  Result<> Load(tree::Document document, const Entries& entries = {}, const std::string& main = "");
  // Halts the tree, which begins at its root at the next tick of Active: a command to begin.
  // Within a tick or a halt: after it. Where a node throws in its halt, the tree rests with that
  // fault instead.
  void Restart();
  // Halts the tree, which rests then. Within a tick or a halt: after it; it outweighs a Restart()
  // or a Load() that halts the nodes.
  void Halt();
  // All of it, for a report or a monitor; valid in this handler.
  TreeView view();
  // Whether it is ticked now: Active, and not stopped. Also true while it rests.
  bool ticking() const;
  // IDLE: there is none, it was halted, or it has not been ticked yet; RUNNING; or how it ended.
  tree::Status result() const;
  const std::string& last_fault() const;  // since Load() or Restart(); "" for none
  // Fails where this process could not run just now, see BreakWatch: a request that has just
  // arrived may be as old. For requests of the application's own that begin motion;
  // <actuator>/send_command has it.
  Result<> CheckNotLate() const;
  // The time of the machine's clock.
  Time Now() const;
  // The same as a stamp of messages, see transport::Clock; zero without a transport.
  msg::Stamp Stamp() const;
  void OnEmergencyStop() override;

 private:
  // Not available: a callback of a derived class would replace the one that runs the tree. Use
  // OnPause() and OnResume() instead.
  using MachineActuator::RegisterStateCallback;

  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace musher
