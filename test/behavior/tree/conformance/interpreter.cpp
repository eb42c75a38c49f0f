#include "musher/test/behavior/tree/conformance/interpreter.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace musher::tree::conformance {

// --- documents ---

std::string TextOf(const Comparison& comparison) {
  return comparison.entry + " " + comparison.by + " " +
         (comparison.text ? "'" + *comparison.text + "'" : std::to_string(comparison.number));
}
std::string TextOf(const Assignment& assignment) {
  return assignment.entry + " " + assignment.by + " " +
         (assignment.text ? "'" + *assignment.text + "'" : std::to_string(assignment.number));
}

namespace {

bool IsLoop(const std::string& kind) {
  return kind.starts_with("Loop");
}

std::string Quoted(const std::string& text) {
  std::string quoted;
  for (const char c : text) quoted += c == '<' ? "&lt;" : std::string(1, c);
  return "=\"" + quoted + "\"";
}

// Appends the trees of its subtrees to `trees`.
std::string ElementOf(const Model& model, std::string& trees, int& subtrees) {
  std::string text = "<" + model.kind;
  if (!model.name.empty()) text += " name" + Quoted(model.name);
  if (!model.does.empty()) text += " does" + Quoted(model.does);
  for (const auto& [port, value] : model.ports) text += " " + port + Quoted(value);
  if (IsLoop(model.kind)) {
    std::string queue;
    for (const std::string& value : model.queue) queue += value + ";";
    text += " queue" + Quoted(queue);
  }
  if (!model.value.empty()) {
    text += " value" + Quoted(IsLoop(model.kind) ? "{" + model.value + "}" : model.value);
  }
  if (model.compares) {
    text += (model.kind == "Precondition" ? " if" : " code") + Quoted(TextOf(*model.compares));
  }
  if (model.assigns) text += " code" + Quoted(TextOf(*model.assigns));
  for (const auto& [when, comparison] : model.before)
    text += " " + when + Quoted(TextOf(comparison));
  for (const auto& [when, assignment] : model.after)
    text += " " + when + Quoted(TextOf(assignment));
  if (!model.ports.contains("_autoremap")) {
    for (const auto& [own, around] : model.entries) text += " " + own + Quoted("{" + around + "}");
  }
  if (model.kind == "SubTree") {
    const std::string id = "Sub" + std::to_string(subtrees++);
    const std::string content = ElementOf(model.children.at(0), trees, subtrees);
    trees += "<BehaviorTree ID" + Quoted(id) + ">\n" + content + "</BehaviorTree>\n";
    return text + " ID" + Quoted(id) + "/>\n";
  }
  if (model.children.empty()) return text + "/>\n";
  text += ">\n";
  for (const Model& child : model.children) text += ElementOf(child, trees, subtrees);
  return text + "</" + model.kind + ">\n";
}

}  // namespace

std::string DocumentOf(const Model& main) {
  std::string trees;
  int subtrees = 0;
  const std::string content = ElementOf(main, trees, subtrees);
  return "<root BTCPP_format=\"4\" main_tree_to_execute=\"Main\">\n<BehaviorTree ID=\"Main\">\n" +
         content + "</BehaviorTree>\n" + trees + "</root>\n";
}

// --- nodes ---

namespace {

// Thrown by a node: why it fails.
class Broken : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};
// The same on its way to the root.
struct Failed {
  Failure failure;
};

}  // namespace

// A node between its start and its end.
class Run {
 public:
  virtual ~Run() = default;
  virtual Status Tick() = 0;
  // What it does beside halting its children, which comes after it.
  virtual void Halt() {}
};

class Node {
 public:
  using Entries = std::map<std::string, std::string>;

  // `entries`: those of the main tree by the ones of its own tree.
  Node(const Model& of, Interpreter& in, const Entries& around)
      : model(of), world(in), number(in.nodes++), entries(around) {
    Entries inner = around;
    if (of.kind == "SubTree") {
      for (auto& [own, outermost] : inner) {
        const auto outer = of.entries.find(own);
        outermost = outer == of.entries.end() ? own + " of " + std::to_string(number)
                                              : around.at(outer->second);
        in.board.try_emplace(outermost);
      }
    }
    for (const Model& child : of.children) {
      children.push_back(std::make_unique<Node>(child, in, inner));
    }
  }

  // Throws Failed.
  Status Tick() {
    const bool ran = run != nullptr;
    try {
      if (const auto instead = Before()) return *instead;
    } catch (const Broken& broken) {
      Halt();
      Fail(broken);
    }
    if (!ran) run = Start();
    Status status = Status::kIdle;
    try {
      status = run->Tick();
    } catch (const Broken& broken) {
      // A leaf is halted, but not one that throws in its first tick; what has children is halted
      // with them, from the root.
      if (children.empty() && ran) Halt();
      if (children.empty()) run = nullptr;
      Fail(broken);
    }
    if (status == Status::kRunning) return status;
    HaltChildren();
    run = nullptr;
    try {
      After(status);
    } catch (const Broken& broken) {
      Fail(broken);
    }
    return status;
  }
  // Nothing where it does not run. What it throws is noted.
  void Halt() {
    if (run == nullptr) return;
    const std::unique_ptr<Run> ended = std::move(run);
    try {
      ended->Halt();
      HaltChildren();
      Assign("_onHalted");
    } catch (const Broken& broken) {
      if (!world.failed_halt) world.failed_halt = Failure{number, broken.what()};
    }
  }
  void HaltAll() {
    Halt();
    for (const auto& child : children) child->HaltAll();
  }
  void HaltChildren() {
    for (const auto& child : children) child->Halt();
  }

  const BoardEntry& Entry(const std::string& key) const { return world.board.at(entries.at(key)); }
  std::string Value(const std::string& key) const {
    if (!Entry(key).value) throw Broken("no value of");
    return *Entry(key).value;
  }
  void Set(const std::string& key, const std::string& value) const {
    world.Set(entries.at(key), value);
  }
  bool True(const Comparison& comparison) const {
    const std::string text = Value(comparison.entry);
    if (comparison.text) return text == *comparison.text;
    const int value = std::stoi(text);
    if (comparison.by == "<") return value < comparison.number;
    if (comparison.by == ">") return value > comparison.number;
    return value == comparison.number;
  }
  int TimeMs(const std::string& port) const {
    const std::string& value = model.ports.at(port);
    return std::stoi(value == "{z}" ? Value("z") : value);
  }
  void Assign(const Assignment& assignment) const {
    if (assignment.text) return Set(assignment.entry, *assignment.text);
    const int before = assignment.by == "+=" ? std::stoi(Value(assignment.entry)) : 0;
    Set(assignment.entry, std::to_string(before + assignment.number));
  }
  void Running(std::vector<bool>& all) const {
    all.push_back(run != nullptr);
    for (const auto& child : children) child->Running(all);
  }

  const Model& model;
  Interpreter& world;
  const std::size_t number;
  const Entries entries;
  std::vector<std::unique_ptr<Node>> children;
  std::unique_ptr<Run> run;  // null: it does not run

  // What outlasts a run: how often a leaf was ticked, the place of a SequenceWithMemory, the rounds
  // of a Repeat whose child was skipped, the result of a RunOnce, how often the entry was set that
  // a node looks at, the last child that was selected.
  std::size_t ticks = 0;
  std::size_t place = 0;
  int rounds = 0;
  std::optional<Status> result;
  int sets = 0;
  Node* selected = nullptr;

 private:
  std::unique_ptr<Run> Start();
  std::unique_ptr<Run> StartControl();
  std::unique_ptr<Run> StartDecorator();
  [[noreturn]] void Fail(const Broken& why) const { throw Failed{{number, why.what()}}; }
  // The result in place of a tick.
  std::optional<Status> Before() {
    const auto holds = [this](const char* when) {
      const auto found = model.before.find(when);
      return found == model.before.end() ? std::nullopt : std::optional(True(found->second));
    };
    if (run != nullptr) {
      if (holds("_while").value_or(true)) return std::nullopt;
      Halt();
      return Status::kSkipped;
    }
    if (holds("_failureIf").value_or(false)) return After(Status::kFailure);
    if (holds("_successIf").value_or(false)) return After(Status::kSuccess);
    if (holds("_skipIf").value_or(false)) return Status::kSkipped;
    return holds("_while").value_or(true) ? std::nullopt : std::optional(Status::kSkipped);
  }
  Status After(Status status) const {
    if (status == Status::kSuccess) Assign("_onSuccess");
    if (status == Status::kFailure) Assign("_onFailure");
    if (IsCompleted(status)) Assign("_post");
    return status;
  }
  void Assign(const char* when) const {
    const auto found = model.after.find(when);
    if (found != model.after.end()) Assign(found->second);
  }
};

namespace {

Status StatusOf(const std::string& text) {
  if (text == "SUCCESS") return Status::kSuccess;
  if (text == "FAILURE") return Status::kFailure;
  return text == "RUNNING" ? Status::kRunning : Status::kSkipped;
}

// --- leaves ---

// Say, Act and Look.
class SayRun : public Run {
 public:
  explicit SayRun(Node& node) : node_(node) {}
  Status Tick() override {
    const bool begins = std::exchange(first_, false) && node_.model.kind == "Say";
    node_.world.log += node_.model.name + (begins ? "^ " : " ");
    const std::string& does = node_.model.does;
    const char letter = does.at(node_.ticks++ % does.size());
    if (letter == '!') throw Broken("it broke");
    if (letter == '*') throw Broken("an unknown exception");
    if (letter == '?') throw Broken("its tick returned no status");
    if (letter == 'I') throw Broken("its tick returned IDLE");
    if (letter == 'S') return Status::kSuccess;
    if (letter == 'F') return Status::kFailure;
    if (letter == '-') return Status::kSkipped;
    if (node_.model.kind == "Act") throw Broken("an action must not return RUNNING");
    if (letter == 'w' && node_.model.kind == "Say") node_.world.WakeUp();
    return Status::kRunning;
  }
  void Halt() override {
    if (node_.model.kind != "Say") return;
    node_.world.log += node_.model.name + "! ";
    if (node_.model.ports.contains("halts")) throw Broken("its halt broke");
  }

 private:
  Node& node_;
  bool first_ = true;
};

class SleepRun : public Run {
 public:
  explicit SleepRun(Node& node) : node_(node) {}
  Status Tick() override {
    if (!until_ms_) until_ms_ = node_.world.now_ms + node_.TimeMs("msec");
    return node_.world.now_ms < *until_ms_ ? Status::kRunning : Status::kSuccess;
  }

 private:
  Node& node_;
  std::optional<std::int64_t> until_ms_;
};

// A leaf that ends in its first tick.
class AtOnceRun : public Run {
 public:
  explicit AtOnceRun(std::function<Status()> what) : what_(std::move(what)) {}
  Status Tick() override { return what_(); }

 private:
  const std::function<Status()> what_;
};

// --- controls ---

// Sequences and fallbacks: one child after the other, while they return `goes_on`.
class InOrderRun : public Run {
 public:
  struct Kind {
    Status goes_on = Status::kSuccess;
    bool yields = false;     // RUNNING behind a child that has ended in its first tick
    bool remembers = false;  // the child to go on with
  };
  InOrderRun(Node& node, Kind kind)
      : node_(node), kind_(kind), place_(kind.remembers ? node.place : own_place_) {}

  Status Tick() override {
    while (place_ < node_.children.size()) {
      Node& child = *node_.children[place_];
      const bool ran = child.run != nullptr;
      const Status status = child.Tick();
      if (status == Status::kRunning) return status;
      if (status != Status::kSkipped && status != kind_.goes_on) return status;
      ++place_;
      if (status == Status::kSkipped) {
        ++skipped_;
      } else if (kind_.yields && !ran && place_ < node_.children.size()) {
        node_.world.again = true;
        return Status::kRunning;
      }
    }
    place_ = 0;
    return skipped_ == node_.children.size() ? Status::kSkipped : kind_.goes_on;
  }

 private:
  Node& node_;
  const Kind kind_;
  std::size_t own_place_ = 0;
  std::size_t& place_;
  std::size_t skipped_ = 0;
};

class ReactiveRun : public Run {
 public:
  ReactiveRun(Node& node, Status goes_on) : node_(node), goes_on_(goes_on) {}
  Status Tick() override {
    bool all_skipped = true;
    for (const auto& child : node_.children) {
      const Status status = child->Tick();
      if (status == Status::kRunning) {
        for (const auto& other : node_.children) {
          if (other != child) other->Halt();
        }
        return status;
      }
      if (status == Status::kSkipped) continue;
      all_skipped = false;
      if (status != goes_on_) return status;
    }
    return all_skipped ? Status::kSkipped : goes_on_;
  }

 private:
  Node& node_;
  const Status goes_on_;
};

int CountOf(int count, std::size_t children) {
  return count >= 0 ? count : std::max(0, static_cast<int>(children) + 1 + count);
}

class ParallelRun : public Run {
 public:
  explicit ParallelRun(Node& node) : node_(node), ended_(node.children.size()) {}
  Status Tick() override {
    const int all = static_cast<int>(node_.children.size());
    const bool counts_skipped = node_.model.Number("success_count") < 0;
    const int needed = CountOf(node_.model.Number("success_count"), node_.children.size());
    const int allowed = CountOf(node_.model.Number("failure_count"), node_.children.size());
    int skipped = 0;
    for (std::size_t i = 0; i < node_.children.size(); ++i) {
      if (!ended_[i]) {
        const Status status = node_.children[i]->Tick();
        if (IsCompleted(status)) ended_[i] = status;
        if (status == Status::kSkipped) ++skipped;
      }
      if (skipped == all) return Status::kSkipped;
      const int successes = Ended(Status::kSuccess);
      const int failures = Ended(Status::kFailure);
      if (successes + (counts_skipped ? skipped : 0) >= needed) return Status::kSuccess;
      if (failures == allowed || all - failures < needed) return Status::kFailure;
    }
    return Status::kRunning;
  }

 private:
  int Ended(Status with) const {
    return static_cast<int>(std::ranges::count(ended_, std::optional(with)));
  }
  Node& node_;
  std::vector<std::optional<Status>> ended_;
};

class ParallelAllRun : public Run {
 public:
  explicit ParallelAllRun(Node& node) : node_(node), ended_(node.children.size()) {}
  Status Tick() override {
    const std::size_t all = node_.children.size();
    std::size_t skipped = 0;
    for (std::size_t i = 0; i < all; ++i) {
      if (ended_[i]) continue;
      const Status status = node_.children[i]->Tick();
      if (IsCompleted(status)) ended_[i] = status;
      if (status == Status::kSkipped) ++skipped;
    }
    if (skipped == all) return Status::kSkipped;
    const auto open = static_cast<std::size_t>(std::ranges::count(ended_, std::optional<Status>()));
    if (open > skipped) return Status::kRunning;
    const auto failures = std::ranges::count(ended_, std::optional(Status::kFailure));
    const int most = CountOf(node_.model.Number("max_failures"), all);
    return failures >= most ? Status::kFailure : Status::kSuccess;
  }

 private:
  Node& node_;
  std::vector<std::optional<Status>> ended_;
};

class IfThenElseRun : public Run {
 public:
  explicit IfThenElseRun(Node& node) : node_(node) {}
  Status Tick() override {
    if (chosen_ == nullptr) {
      const Status condition = node_.children[0]->Tick();
      if (!IsCompleted(condition)) return condition;
      const std::size_t child = condition == Status::kSuccess ? 1 : 2;
      if (child >= node_.children.size()) return condition;
      chosen_ = node_.children[child].get();
    }
    return chosen_->Tick();
  }

 private:
  Node& node_;
  Node* chosen_ = nullptr;
};

class WhileDoElseRun : public Run {
 public:
  explicit WhileDoElseRun(Node& node) : node_(node) {}
  Status Tick() override {
    const Status condition = node_.children[0]->Tick();
    if (condition == Status::kRunning) {
      for (std::size_t i = 1; i < node_.children.size(); ++i) node_.children[i]->Halt();
    }
    if (!IsCompleted(condition)) return condition;
    const std::size_t chosen = condition == Status::kSuccess ? 1 : 2;
    if (chosen >= node_.children.size()) return condition;
    if (node_.children.size() == 3) node_.children[3 - chosen]->Halt();
    return node_.children[chosen]->Tick();
  }

 private:
  Node& node_;
};

// Its variable is x, with numbers as cases, or s, with texts.
class SwitchRun : public Run {
 public:
  explicit SwitchRun(Node& node) : node_(node) {}
  Status Tick() override {
    const auto& ports = node_.model.ports;
    const auto variable = ports.find("variable");
    std::optional<std::string> value;
    if (variable != ports.end()) value = node_.Entry(variable->second.substr(1, 1)).value;
    const auto is_case = [&](std::size_t child) {
      const auto found = ports.find("case_" + std::to_string(child + 1));
      return value && found != ports.end() && found->second == *value;
    };
    std::size_t chosen = 0;
    while (chosen + 1 < node_.children.size() && !is_case(chosen)) ++chosen;
    for (std::size_t i = 0; i < node_.children.size(); ++i) {
      if (i != chosen) node_.children[i]->Halt();
    }
    return node_.children[chosen]->Tick();
  }

 private:
  Node& node_;
};

// The child whose name stands in s, to its end.
class ManualSelectorRun : public Run {
 public:
  explicit ManualSelectorRun(Node& node) : node_(node) {}
  Status Tick() override {
    if (chosen_ == nullptr) {
      const std::string wanted = node_.Entry("s").value.value_or("");
      if (wanted == "SUCCESS" || wanted == "FAILURE") {
        node_.Set("s", "");
        return StatusOf(wanted);
      }
      chosen_ = Named(wanted);
      if (chosen_ != nullptr) node_.Set("s", "");
      const bool repeats = node_.model.ports.at("repeat_last_selection") == "true";
      if (wanted.empty() && repeats) chosen_ = node_.selected;
      if (chosen_ == nullptr) return Status::kRunning;
      node_.selected = chosen_;
    }
    return chosen_->Tick();
  }

 private:
  Node* Named(const std::string& name) const {
    for (const auto& child : node_.children) {
      if (name == (child->model.name.empty() ? child->model.kind : child->model.name)) {
        return child.get();
      }
    }
    return nullptr;
  }
  Node& node_;
  Node* chosen_ = nullptr;
};

// One tick, to bring things in order in a halt.
void CleanUp(Node& child) {
  try {
    child.Tick();
  } catch (const Failed& failed) {
    child.Halt();
    throw Broken(failed.failure.why);
  }
  child.Halt();
}

class TryCatchRun : public Run {
 public:
  explicit TryCatchRun(Node& node) : node_(node) {}
  Status Tick() override {
    const std::size_t tries = node_.children.size() - 1;
    for (; !catches_ && place_ < tries; ++place_) {
      const Status status = node_.children[place_]->Tick();
      if (status == Status::kRunning) return status;
      if (status == Status::kSkipped) ++skipped_;
      if (status == Status::kFailure) catches_ = true;
    }
    if (catches_) {
      const Status status = node_.children.back()->Tick();
      return status == Status::kRunning ? status : Status::kFailure;
    }
    return skipped_ == tries ? Status::kSkipped : Status::kSuccess;
  }
  void Halt() override {
    if (catches_ || node_.model.ports.at("catch_on_halt") != "true") return;
    for (std::size_t i = 0; i + 1 < node_.children.size(); ++i) node_.children[i]->Halt();
    CleanUp(*node_.children.back());
  }

 private:
  Node& node_;
  std::size_t place_ = 0;
  std::size_t skipped_ = 0;
  bool catches_ = false;
};

class FinallyRun : public Run {
 public:
  explicit FinallyRun(Node& node) : node_(node) {}
  Status Tick() override {
    if (!result_) {
      const Status status = node_.children[0]->Tick();
      if (status == Status::kRunning) return status;
      result_ = status;
    }
    cleaned_up_ = true;  // also where it fails
    const Status cleanup = node_.children[1]->Tick();
    cleaned_up_ = cleanup != Status::kRunning;
    return cleaned_up_ && cleanup != Status::kFailure ? *result_ : cleanup;
  }
  void Halt() override {
    node_.children[0]->Halt();
    if (!cleaned_up_) CleanUp(*node_.children[1]);
  }

 private:
  Node& node_;
  std::optional<Status> result_;
  bool cleaned_up_ = false;
};

// --- decorators ---

// Another result for that of the child.
class ResultRun : public Run {
 public:
  ResultRun(Node& node, std::function<Status(Status)> result)
      : node_(node), result_(std::move(result)) {}
  Status Tick() override { return result_(node_.children[0]->Tick()); }

 private:
  Node& node_;
  const std::function<Status(Status)> result_;
};

// Repeat and RetryUntilSuccessful.
class AgainRun : public Run {
 public:
  AgainRun(Node& node, Status again, int limit) : node_(node), again_(again), limit_(limit) {}
  Status Tick() override {
    while (limit_ == -1 || node_.rounds < limit_) {
      Node& child = *node_.children[0];
      const bool ran = child.run != nullptr;
      const Status status = child.Tick();
      if (!IsCompleted(status)) return status;
      if (status != again_) return End(status);
      ++node_.rounds;
      const bool last = limit_ != -1 && node_.rounds >= limit_;
      if (ran || last) continue;
      node_.world.again = true;
      return Status::kRunning;
    }
    return End(again_);
  }
  void Halt() override { node_.rounds = 0; }

 private:
  Status End(Status status) {
    node_.rounds = 0;
    return status;
  }
  Node& node_;
  const Status again_;
  const int limit_;
};

class DelayRun : public Run {
 public:
  explicit DelayRun(Node& node) : node_(node) {}
  Status Tick() override {
    if (!until_ms_) until_ms_ = node_.world.now_ms + node_.TimeMs("delay_msec");
    return node_.world.now_ms < *until_ms_ ? Status::kRunning : node_.children[0]->Tick();
  }

 private:
  Node& node_;
  std::optional<std::int64_t> until_ms_;
};

class TimeoutRun : public Run {
 public:
  explicit TimeoutRun(Node& node) : node_(node), begun_ms_(node.world.now_ms) {}
  Status Tick() override {
    if (!limit_ms_) limit_ms_ = node_.TimeMs("msec");
    const bool over = *limit_ms_ > 0 && node_.world.now_ms - begun_ms_ >= *limit_ms_;
    return over ? Status::kFailure : node_.children[0]->Tick();
  }

 private:
  Node& node_;
  std::optional<int> limit_ms_;
  const std::int64_t begun_ms_;
};

class RunOnceRun : public Run {
 public:
  explicit RunOnceRun(Node& node) : node_(node) {}
  Status Tick() override {
    if (node_.result) {
      return node_.model.ports.at("then_skip") == "true" ? Status::kSkipped : *node_.result;
    }
    const Status status = node_.children[0]->Tick();
    if (IsCompleted(status)) node_.result = status;
    return status;
  }

 private:
  Node& node_;
};

class PreconditionRun : public Run {
 public:
  explicit PreconditionRun(Node& node) : node_(node) {}
  Status Tick() override {
    Node& child = *node_.children[0];
    if (child.run == nullptr && !node_.True(*node_.model.compares)) {
      return StatusOf(node_.model.ports.at("else"));
    }
    return child.Tick();
  }

 private:
  Node& node_;
};

class LoopRun : public Run {
 public:
  explicit LoopRun(Node& node) : node_(node) {}
  Status Tick() override {
    Node& child = *node_.children[0];
    if (child.run == nullptr) {
      if (round_ == node_.model.queue.size()) return StatusOf(node_.model.ports.at("if_empty"));
      node_.Set(node_.model.value, NumberOf(node_.model.queue[round_++]));
    }
    return child.Tick() == Status::kFailure ? Status::kFailure : Status::kRunning;
  }

 private:
  static std::string NumberOf(const std::string& value) {
    return value == "true" ? "1" : value == "false" ? "0" : value;
  }
  Node& node_;
  std::size_t round_ = 0;
};

// Whether the entry was set since the last look of this node at it.
bool WasSet(Node& node) {
  const int sets = node.Entry(node.model.ports.at("entry").substr(1, 1)).sets;
  return std::exchange(node.sets, sets) != sets;
}

// SkipUnlessUpdated and WaitValueUpdate.
class WhenUpdatedRun : public Run {
 public:
  WhenUpdatedRun(Node& node, Status otherwise) : node_(node), otherwise_(otherwise) {}
  Status Tick() override {
    Node& child = *node_.children[0];
    return child.run != nullptr || WasSet(node_) ? child.Tick() : otherwise_;
  }

 private:
  Node& node_;
  const Status otherwise_;
};

void SetBlackboard(const Node& node) {
  const std::string& value = node.model.value;
  node.Set(node.model.ports.at("output_key"),
           value.starts_with('{') ? node.Value(value.substr(1, 1)) : value);
}

Status Inverted(Status status) {
  if (status == Status::kSuccess) return Status::kFailure;
  return status == Status::kFailure ? Status::kSuccess : status;
}

}  // namespace

std::unique_ptr<Run> Node::Start() {
  const std::string& kind = model.kind;
  if (kind == "Say" || kind == "Act" || kind == "Look") return std::make_unique<SayRun>(*this);
  if (kind == "Sleep") return std::make_unique<SleepRun>(*this);
  if (kind == "AlwaysSuccess") return std::make_unique<AtOnceRun>([] { return Status::kSuccess; });
  if (kind == "AlwaysFailure") return std::make_unique<AtOnceRun>([] { return Status::kFailure; });
  if (kind == "Script") {
    return std::make_unique<AtOnceRun>([this] {
      Assign(*model.assigns);
      return Status::kSuccess;
    });
  }
  if (kind == "ScriptCondition") {
    return std::make_unique<AtOnceRun>(
        [this] { return True(*model.compares) ? Status::kSuccess : Status::kFailure; });
  }
  if (kind == "SetBlackboard") {
    return std::make_unique<AtOnceRun>([this] {
      SetBlackboard(*this);
      return Status::kSuccess;
    });
  }
  if (kind == "UnsetBlackboard") {
    return std::make_unique<AtOnceRun>([this] {
      const auto entry = entries.find(model.ports.at("key"));
      if (entry != entries.end()) world.board.at(entry->second).value.reset();
      return Status::kSuccess;
    });
  }
  if (kind == "WasEntryUpdated" || kind == "EntryUpdated") {
    return std::make_unique<AtOnceRun>(
        [this] { return WasSet(*this) ? Status::kSuccess : Status::kFailure; });
  }
  auto control = StartControl();
  return control != nullptr ? std::move(control) : StartDecorator();
}

// Null: it is none.
std::unique_ptr<Run> Node::StartControl() {
  const std::string& kind = model.kind;
  using InOrder = InOrderRun::Kind;
  const std::map<std::string, InOrder> in_order = {
      {"Sequence", {}},
      {"AsyncSequence", {.yields = true}},
      {"SequenceWithMemory", {.yields = true, .remembers = true}},
      {"Fallback", {.goes_on = Status::kFailure}},
      {"AsyncFallback", {.goes_on = Status::kFailure, .yields = true}}};
  if (in_order.contains(kind)) return std::make_unique<InOrderRun>(*this, in_order.at(kind));
  if (kind == "ReactiveSequence") return std::make_unique<ReactiveRun>(*this, Status::kSuccess);
  if (kind == "ReactiveFallback") return std::make_unique<ReactiveRun>(*this, Status::kFailure);
  if (kind == "Parallel") return std::make_unique<ParallelRun>(*this);
  if (kind == "ParallelAll") return std::make_unique<ParallelAllRun>(*this);
  if (kind == "IfThenElse") return std::make_unique<IfThenElseRun>(*this);
  if (kind == "WhileDoElse") return std::make_unique<WhileDoElseRun>(*this);
  if (kind.starts_with("Switch")) return std::make_unique<SwitchRun>(*this);
  if (kind == "TryCatch") return std::make_unique<TryCatchRun>(*this);
  if (kind == "Finally") return std::make_unique<FinallyRun>(*this);
  if (kind == "ManualSelector") return std::make_unique<ManualSelectorRun>(*this);
  return nullptr;
}

std::unique_ptr<Run> Node::StartDecorator() {
  const std::string& kind = model.kind;
  if (kind == "Repeat") {
    return std::make_unique<AgainRun>(*this, Status::kSuccess, model.Number("num_cycles"));
  }
  if (kind == "RetryUntilSuccessful") {
    return std::make_unique<AgainRun>(*this, Status::kFailure, model.Number("num_attempts"));
  }
  if (kind == "Delay") return std::make_unique<DelayRun>(*this);
  if (kind == "Timeout") return std::make_unique<TimeoutRun>(*this);
  if (kind == "RunOnce") return std::make_unique<RunOnceRun>(*this);
  if (kind == "Precondition") return std::make_unique<PreconditionRun>(*this);
  if (IsLoop(kind)) return std::make_unique<LoopRun>(*this);
  if (kind == "SkipUnlessUpdated" || kind == "WaitValueUpdate") {
    const bool waits = kind == "WaitValueUpdate";
    return std::make_unique<WhenUpdatedRun>(*this, waits ? Status::kRunning : Status::kSkipped);
  }
  const std::map<std::string, std::function<Status(Status)>> results = {
      {"SubTree", [](Status status) { return status; }},
      {"Inverter", Inverted},
      {"ForceSuccess",
       [](Status status) { return IsCompleted(status) ? Status::kSuccess : status; }},
      {"ForceFailure",
       [](Status status) { return IsCompleted(status) ? Status::kFailure : status; }},
      {"KeepRunningUntilFailure",
       [](Status status) { return status == Status::kFailure ? status : Status::kRunning; }}};
  return std::make_unique<ResultRun>(*this, results.at(kind));
}

Interpreter::Interpreter(const Model& main) {
  Node::Entries own;
  for (const auto& [entry, value] : kEntries) {
    own[entry] = entry;
    Set(entry, value);
  }
  root_ = std::make_unique<Node>(main, *this, own);
}

Interpreter::~Interpreter() = default;

// Where a node fails, also in its halt, every running node is halted once.
Outcome Interpreter::Tick(std::int64_t at_ms) {
  now_ms = at_ms;
  again = called_ = false;
  in_tick_ = true;
  failed_halt.reset();
  Outcome outcome;
  try {
    outcome.status = root_->Tick();
    outcome.failure = failed_halt;
  } catch (const Failed& failed) {
    outcome.failure = failed.failure;
  }
  if (outcome.failure) HaltAll();
  in_tick_ = false;
  return outcome;
}

Outcome Interpreter::TickOnce(std::int64_t at_ms) {
  Outcome outcome = Tick(at_ms);
  for (int i = 1; i < 100 && again && !outcome.failure; ++i) {
    if (outcome.status != Status::kRunning) break;
    outcome = Tick(at_ms);
  }
  return outcome;
}

Outcome Interpreter::Halt(std::int64_t at_ms) {
  now_ms = at_ms;
  failed_halt.reset();
  HaltAll();
  return {Status::kIdle, failed_halt};
}

void Interpreter::HaltAll() {
  root_->Halt();
  root_->HaltAll();
}

void Interpreter::WakeUp() {
  if (in_tick_) {
    again = true;
  } else if (!std::exchange(called_, true)) {
    log += "~ ";
  }
}

void Interpreter::Set(const std::string& entry, const std::string& value) {
  board[entry].value = value;
  ++board[entry].sets;
}

std::vector<bool> Interpreter::Running() const {
  std::vector<bool> all;
  root_->Running(all);
  return all;
}

}  // namespace musher::tree::conformance
