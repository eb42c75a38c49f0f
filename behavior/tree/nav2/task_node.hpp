#pragma once
// A node that is a task of the robot (robot.hpp); only for the sources of this folder.

#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "musher/behavior/tree/nav2/robot.hpp"
#include "musher/behavior/tree/node.hpp"
#include "musher/behavior/tree/setup.hpp"

namespace musher::tree::nav2 {

// One task of the robot, from its start to its end. A halt cancels it. The code of a failure is
// there until the node ends otherwise or is halted, and for the next run of the tree no more.
class TaskNode : public StatefulAction, public RunObserver {
 protected:
  TaskNode(Setup& setup, std::uint16_t unknown)
      : code_(setup.Output<std::uint16_t>("error_code_id", "of nav2's action; 0: success")),
        error_(setup.Output<std::string>("error_msg", "why it has failed")),
        unknown_(unknown) {
    IgnoreServer(setup);
  }

  static void IgnoreServer(Setup& setup) {
    static_cast<void>(setup.OptionalInput<std::string>("server_name", "ignored"));
    static_cast<void>(setup.OptionalInput<double>("server_timeout", "ignored: ms"));
  }

  // In the constructor: a node such as CancelSpin ends it.
  void EndsBy(const Robot& robot, Cancellable kind) {
    robot_ = &robot;
    kind_ = kind;
  }

  // Null: the robot has no such task.
  virtual std::unique_ptr<Task> Begin() = 0;
  // Its end, or that of the cancelled one.
  virtual void OnEnd(const TaskEnd& /*end*/) {}
  virtual Status StatusOf(const TaskEnd& end) const {
    return end.success ? Status::kSuccess : Status::kFailure;
  }
  // That the node has, of a failed task.
  virtual std::uint16_t CodeOf(const TaskEnd& end) const { return end.error_code; }

  // Null: it has ended, or the robot has none.
  const Task* task() const { return task_.get(); }

  Status Poll(Time now) {
    if (task_ == nullptr) return Finish({.error = "the robot does not have this action"});
    if (robot_ != nullptr && robot_->cancels(kind_) != cancels_) {
      task_.reset();
      return Finish({.error = "a node of a tree has cancelled it"});
    }
    const std::optional<TaskEnd> end = task_->Poll(now);
    if (!end) return Status::kRunning;
    task_.reset();
    return Finish(*end);
  }
  void Replace() {
    std::unique_ptr<Task> next = Begin();  // the one before is cancelled when it is replaced
    task_ = std::move(next);
  }
  void OnNewRun(const Tick& /*tick*/) override {
    if (failed_) SetCode(kNoError, "");
  }

 private:
  Status OnStart(const Tick& tick) override {
    try {
      if (robot_ != nullptr) cancels_ = robot_->cancels(kind_);
      Replace();
      return Poll(tick.now);
    } catch (...) {
      task_.reset();
      throw;
    }
  }
  Status OnRunning(const Tick& tick) override { return Poll(tick.now); }
  void OnHalted(const Tick& /*tick*/) override {
    task_.reset();
    SetCode(kNoError, "");
    OnEnd({});
  }

  Status Finish(const TaskEnd& end) {
    const std::uint16_t code = end.success ? kNoError : CodeOf(end);
    SetCode(end.success || code != kNoError ? code : unknown_, end.error);
    OnEnd(end);
    return StatusOf(end);
  }
  void SetCode(std::uint16_t code, const std::string& error) {
    failed_ = code != kNoError;
    code_.Set(code);
    error_.Set(error);
  }

  OutPort<std::uint16_t> code_;
  OutPort<std::string> error_;
  const std::uint16_t unknown_;
  bool failed_ = false;
  const Robot* robot_ = nullptr;  // null: no node cancels it
  Cancellable kind_{};
  std::uint64_t cancels_ = 0;  // before it began
  std::unique_ptr<Task> task_;
};

}  // namespace musher::tree::nav2
