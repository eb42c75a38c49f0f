#pragma once
// A small behaviour tree as an actuator, with a log of its nodes and hooks.

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "musher/application/tree_actuator.hpp"
#include "musher/behavior/tree/xml/tree_xml.hpp"
#include "musher/test/application/show.hpp"

namespace musher::testing {

inline constexpr const char* kCourse = R"(<root BTCPP_format="4">
  <BehaviorTree ID="Course">
    <Sequence>
      <Walk name="first" ticks="{ticks}"/>
      <Walk name="second" ticks="2"/>
    </Sequence>
  </BehaviorTree>
</root>
)";

// The log of the nodes and hooks, and what they are to throw; accessed on the loop.
struct CourseData {
  std::vector<std::string> log;
  std::map<std::string, std::string> throws;
  std::map<std::string, std::function<void()>> does;
  tree::WakeUp wake_up;  // of the present tree

  void Do(const std::string& what) {
    log.push_back(what);
    if (const auto found = does.find(what); found != does.end()) found->second();
    if (const auto found = throws.find(what); found != throws.end()) {
      throw std::runtime_error(found->second);
    }
  }
};

// RUNNING for some ticks.
class Walk : public tree::StatefulAction {
 public:
  Walk(tree::Setup& setup, CourseData& data)
      : data_(data), name_(setup.name()), ticks_(setup.Input<int>("ticks", 1)) {
    data.wake_up = setup.wake_up();
  }

 private:
  tree::Status OnStart(const tree::Tick&) override {
    left_ = ticks_.Get();
    data_.Do(name_ + " starts");
    return Left();
  }
  tree::Status OnRunning(const tree::Tick&) override { return Left(); }
  void OnHalted(const tree::Tick&) override { data_.Do(name_ + " halted"); }
  tree::Status Left() { return --left_ > 0 ? tree::Status::kRunning : tree::Status::kSuccess; }

  CourseData& data_;
  const std::string name_;
  tree::InPort<int> ticks_;
  int left_ = 0;
};

class Course : public TreeActuator, public Inspected<Course> {
 public:
  explicit Course(Options options = {.rate_hz = 50, .begin = Begin::kAtActive})
      : TreeActuator("show", std::move(options)) {}

  CourseData& data() { return data_; }  // before Start(), or by RunOnLoop()
  std::vector<std::string> TakeLog() {
    return Of([](Course& course) { return std::exchange(course.data_.log, {}); });
  }
  tree::Status Result() {
    return Of([](Course& course) { return course.result(); });
  }
  std::vector<tree::Status> TakeTicks() {
    return Of([](Course& course) { return std::exchange(course.ticks_, {}); });
  }
  musher::Result<> LoadText(const std::string& text, const Entries& entries = {}) {
    return Of([&](Course& course) {
      tree::Reading read = tree::ReadTree(text, "new.xml");
      return course.Load(std::move(read.document), entries);
    });
  }

  using TreeActuator::CheckNotLate;
  using TreeActuator::Halt;
  using TreeActuator::last_fault;
  using TreeActuator::Load;
  using TreeActuator::Now;
  using TreeActuator::Restart;
  using TreeActuator::result;
  using TreeActuator::Stamp;
  using TreeActuator::ticking;
  using TreeActuator::tree;

  std::string text = kCourse;  // before Start()

 private:
  musher::Result<> RegisterNodes(tree::Factory& factory) override {
    return factory.Add<Walk>("Walk", data_);
  }
  musher::Result<tree::Document> LoadTree() override {
    if (text.empty()) return TreeActuator::LoadTree();
    return tree::ReadTree(text, "course.xml").document;
  }
  musher::Result<> FillBlackboard(tree::Board& board) override { return board.Set("ticks", 3); }
  void BeforeTick(Time) override {
    if (data_.throws.contains("before") || data_.does.contains("before")) data_.Do("before");
  }
  void AfterTick(Time, tree::Status status) override {
    ticks_.push_back(status);
    if (data_.throws.contains("after") || data_.does.contains("after")) data_.Do("after");
  }
  void OnPause() override { data_.Do("pauses"); }
  void OnResume() override { data_.Do("resumes"); }

  CourseData data_;
  std::vector<tree::Status> ticks_;
};

}  // namespace musher::testing
