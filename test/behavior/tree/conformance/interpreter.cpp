#include "musher/test/behavior/tree/conformance/interpreter.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>
#include <utility>

namespace musher::tree::conformance {

// --- documents ---

namespace {

bool IsLoop(const std::string& kind) {
  return kind.starts_with("Loop");
}

std::string Quoted(const std::string& text) {
  std::string quoted;
  for (const char c : text) {
    quoted += c == '<' ? "&lt;" : c == '&' ? "&amp;" : c == '"' ? "&quot;" : std::string(1, c);
  }
  return "=\"" + quoted + "\"";
}

// The key of "{x}". Nothing: it is a text.
std::optional<std::string> KeyIn(const std::string& value) {
  if (!value.starts_with('{')) return std::nullopt;
  return value.substr(1, value.size() - 2);
}

// The parts of a document beside its main tree.
struct Parts {
  std::set<std::string> ids;
  std::string trees;
  std::string models;
};

std::string AttributesOf(const Model& model) {
  std::string text;
  if (!model.name.empty()) text += " name" + Quoted(model.name);
  if (!model.does.empty()) text += " does" + Quoted(model.does);
  for (const auto& [port, value] : model.ports) text += " " + port + Quoted(value);
  if (IsLoop(model.kind) && !model.ports.contains("queue")) {
    std::string queue;
    for (const std::string& value : model.queue) queue += value + ";";
    text += " queue" + Quoted(queue);
  }
  if (!model.value.empty()) text += " value" + Quoted(model.value);
  if (model.code) {
    text += (model.kind == "Precondition" ? " if" : " code") + Quoted(TextOf(*model.code));
  }
  for (const auto& [when, script] : model.scripts) text += " " + when + Quoted(TextOf(script));
  for (const auto& [own, around] : model.entries) {
    text += " " + own + Quoted(own == around && own > "d" ? "{=}" : "{" + around + "}");
  }
  for (const auto& [own, value] : model.fixed) text += " " + own + Quoted(value);
  return text;
}

std::string ElementOf(const Model& model, Parts& parts);

// Of the tree of a subtree, and of its model.
void AddTree(const Model& subtree, Parts& parts) {
  if (!parts.ids.insert(subtree.id).second) return;
  const std::string id = " ID" + Quoted(subtree.id) + ">\n";
  const std::string content = ElementOf(subtree.children.at(0), parts);
  parts.trees += "<BehaviorTree" + id + content + "</BehaviorTree>\n";
  if (subtree.defaults.empty()) return;
  parts.models += "<SubTree" + id;
  for (const auto& [own, value] : subtree.defaults) {
    parts.models += "<inout_port name" + Quoted(own) + " default" + Quoted(value) + "/>\n";
  }
  parts.models += "</SubTree>\n";
}

// Some leaves are written in the long form.
std::string BeginOf(const Model& model) {
  if (!model.name.ends_with('3') || !model.children.empty()) return "<" + model.kind;
  return (model.kind == "Look" ? "<Condition ID" : "<Action ID") + Quoted(model.kind);
}

std::string ElementOf(const Model& model, Parts& parts) {
  std::string text = BeginOf(model) + AttributesOf(model);
  if (model.kind == "SubTree") {
    AddTree(model, parts);
    return text + " ID" + Quoted(model.id) + "/>\n";
  }
  if (model.children.empty()) return text + "/>\n";
  text += ">\n";
  for (const Model& child : model.children) text += ElementOf(child, parts);
  return text + "</" + model.kind + ">\n";
}

}  // namespace

std::string DocumentOf(const Model& main) {
  Parts parts;
  const std::string content = ElementOf(main, parts);
  const std::string models =
      parts.models.empty() ? "" : "<TreeNodesModel>\n" + parts.models + "</TreeNodesModel>\n";
  return "<root BTCPP_format=\"4\" main_tree_to_execute=\"Main\">\n<BehaviorTree ID=\"Main\">\n" +
         content + "</BehaviorTree>\n" + parts.trees + models + "</root>\n";
}

// --- nodes ---

namespace {

// Broken on its way to the root.
struct Failed {
  Failure failure;
};

// "12", "-3"
std::optional<double> WholeIn(const std::string& text) {
  constexpr std::size_t kMostDigits = 15;
  const std::string digits = text.starts_with('-') ? text.substr(1) : text;
  if (digits.empty() || digits.size() > kMostDigits) return std::nullopt;
  if (digits.find_first_not_of("0123456789") != std::string::npos) return std::nullopt;
  return std::stod(text);
}

// "1;2" of that, or of json:{"x": 1, "y": 2}
std::optional<std::string> PlaceIn(const std::string& text) {
  constexpr std::size_t kMostDigits = 9;
  const std::string before_x = R"(json:{"x": )";
  const std::string before_y = R"(, "y": )";
  std::string plain = text;
  if (text.starts_with(before_x)) {
    plain = text.substr(before_x.size(), text.size() - before_x.size() - 1);
    plain.replace(plain.find(before_y), before_y.size(), ";");
  }
  const std::size_t at = plain.find(';');
  if (at > kMostDigits || !WholeIn(plain.substr(0, at))) return std::nullopt;
  return WholeIn(plain.substr(at + 1)) ? std::optional(plain) : std::nullopt;
}

std::optional<double> NumberAs(Holds holds, const Datum& datum) {
  const auto* const text = std::get_if<std::string>(&datum);
  std::optional<double> number;
  if (text == nullptr) {
    number = std::get<double>(datum);
  } else if (holds == Holds::kTruth) {
    if (*text == "true" || *text == "1") number = 1;
    if (*text == "false" || *text == "0") number = 0;
  } else {
    number = holds == Holds::kNumber && !kEnums.contains(*text) ? NumberIn(*text) : WholeIn(*text);
  }
  if (!number || holds == Holds::kNumber) return number;
  if (holds == Holds::kTruth) return *number != 0 ? 1 : 0;
  const double least = holds == Holds::kFromZero ? 0 : -0x1p31;
  const double above = holds == Holds::kFromZero ? 0x1p32 : 0x1p31;
  const bool fits = std::floor(*number) == *number && *number >= least && *number < above;
  return fits ? std::optional(*number + 0.0) : std::nullopt;
}

// Nothing: the value can not become one of that type.
std::optional<Datum> As(Holds holds, const Datum& datum) {
  if (holds == Holds::kAnything) return datum;
  if (holds == Holds::kText) return TextOf(datum);
  if (holds == Holds::kPlace) {
    const auto* const text = std::get_if<std::string>(&datum);
    const auto place = text == nullptr ? std::nullopt : PlaceIn(*text);
    return place ? std::optional<Datum>(*place) : std::nullopt;
  }
  const auto number = NumberAs(holds, datum);
  return number ? std::optional<Datum>(*number) : std::nullopt;
}

// The type of a port that reads or writes an entry. Nothing: it only names a key.
std::optional<Holds> TypeOfPort(const std::string& kind, const std::string& port) {
  static const std::map<std::string, std::optional<Holds>> kTypes = {
      {"case_1", Holds::kAnything},
      {"case_2", Holds::kAnything},
      {"delay_msec", Holds::kFromZero},
      {"entry", std::nullopt},
      {"failure_count", Holds::kWhole},
      {"in", Holds::kWhole},
      {"keeps", Holds::kWhole},
      {"key", std::nullopt},
      {"max_failures", Holds::kWhole},
      {"msec", Holds::kFromZero},
      {"num_attempts", Holds::kWhole},
      {"num_cycles", Holds::kWhole},
      {"out", Holds::kWhole},
      {"output_key", std::nullopt},
      {"place", Holds::kPlace},
      {"queue", Holds::kAnything},
      {"repeat_last_selection", Holds::kTruth},
      {"selection", Holds::kText},
      {"success_count", Holds::kWhole},
      {"then_skip", Holds::kTruth},
      {"variable", Holds::kAnything},
      {"what", Holds::kAnything}};
  if (port == "to") return kind == "Print" ? Holds::kText : Holds::kPlace;
  return kTypes.at(port);
}

Holds TypeOfLoop(const std::string& kind) {
  static const std::map<std::string, Holds> kTypes = {{"LoopInt", Holds::kWhole},
                                                      {"LoopBool", Holds::kTruth},
                                                      {"LoopDouble", Holds::kNumber},
                                                      {"LoopString", Holds::kText}};
  return kTypes.at(kind);
}

}  // namespace

// A node between its start and its end.
class Run {
 public:
  virtual ~Run() = default;
  virtual Status Tick() = 0;
  // What it does beside halting its children, which comes after it.
  virtual void Halt() {}
};

class Node : public Entries {
 public:
  using Keys = std::map<std::string, std::string>;

  // `around`: those of the board by the keys of its own tree.
  Node(const Model& of, Interpreter& in, const Keys& around)
      : model(of), world(in), number(in.nodes++), keys(around) {
    UsePorts();
    const Keys inner = of.kind == "SubTree" ? KeysWithin() : around;
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
      RunScript("_onHalted");
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

  BoardEntry& Entry(const std::string& key) const {
    return world.board.at(key.starts_with('@') ? key.substr(1) : keys.at(key));
  }
  Datum Value(const std::string& key) const override {
    if (!Entry(key).value) throw Broken("no value of");
    return *Entry(key).value;
  }
  void Set(const std::string& key, const Datum& datum) override {
    BoardEntry& entry = Entry(key);
    const auto fitting = As(entry.holds, datum);
    if (!fitting) throw Broken("is not valid: expected");
    entry.value = *fitting;
    ++entry.sets;
  }
  bool MayAssign(const std::string& key) const override {
    return Entry(key).value.has_value() || Entry(key).declared;
  }

  // With defaults. Nothing: the port is left out, and has none.
  std::optional<std::string> ValueOf(const std::string& port) const {
    static const std::map<std::string, std::string> kDefaults = {{"success_count", "-1"},
                                                                 {"failure_count", "1"},
                                                                 {"max_failures", "1"},
                                                                 {"in", "{x}"},
                                                                 {"keeps", "{y}"}};
    const auto value = model.ports.find(port);
    if (value != model.ports.end()) return value->second;
    const auto otherwise = kDefaults.find(port);
    return otherwise == kDefaults.end() ? std::nullopt : std::optional(otherwise->second);
  }
  // What a port has: its text, or its entry.
  Datum Read(const std::string& port, Holds as) const {
    const std::string value = ValueOf(port).value();
    const auto key = KeyIn(value);
    const auto known = kEnums.find(value);
    if (as == Holds::kWhole && known != kEnums.end()) return known->second;
    const auto fitting = As(as, key ? Value(*key) : Datum(value));
    if (!fitting) throw Broken("is not of the port's type");
    return *fitting;
  }
  int Number(const std::string& port) const {
    return static_cast<int>(std::get<double>(Read(port, Holds::kWhole)));
  }
  bool IsTrue(const std::string& port) const {
    return std::get<double>(Read(port, Holds::kTruth)) != 0;
  }
  std::int64_t Milliseconds(const std::string& port) const {
    return static_cast<std::int64_t>(std::get<double>(Read(port, Holds::kFromZero)));
  }
  // Where the port is there, and is an entry.
  void Write(const std::string& port, const Datum& datum) {
    const auto value = ValueOf(port);
    const auto key = value ? KeyIn(*value) : std::nullopt;
    if (key) Set(*key, datum);
  }
  bool True(const Expression& condition) { return TruthOf(Evaluate(condition, *this)); }

  void Running(std::vector<bool>& all) const {
    all.push_back(run != nullptr);
    for (const auto& child : children) child->Running(all);
  }

  const Model& model;
  Interpreter& world;
  const std::size_t number;
  const Keys keys;  // those of the board by the ones of its tree
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
  std::unique_ptr<Run> StartLeaf();
  [[noreturn]] void Fail(const Broken& why) const { throw Failed{{number, why.what()}}; }

  // Of a SubTree.
  Keys KeysWithin() const {
    const auto around = [this](const std::string& key) { return keys.at(key); };
    Keys inner;
    for (const auto& [own, value] : kEntries) {
      const auto given = model.entries.find(own);
      const auto otherwise = model.defaults.find(own);
      const bool remaps = model.ports.contains("_autoremap");
      std::optional<std::string> text;
      std::optional<std::string> outer;
      if (const auto fixed = model.fixed.find(own); fixed != model.fixed.end()) {
        text = fixed->second;
      } else if (given != model.entries.end()) {
        outer = given->second;
      } else if (remaps) {
        if (!own.starts_with('_')) outer = own;
      } else if (otherwise != model.defaults.end()) {
        outer = KeyIn(otherwise->second);
        if (!outer) text = otherwise->second;
      }
      inner[own] = outer ? around(*outer) : own + " of " + std::to_string(number);
      world.board.try_emplace(inner[own]);
      if (text) world.constants.emplace_back(inner[own], *text);
    }
    return inner;
  }
  void Use(const std::string& key, Holds as) const {
    BoardEntry& entry = Entry(key);
    entry.declared = true;
    if (as == Holds::kAnything || as == entry.holds || entry.mixed) return;
    entry.mixed = entry.holds != Holds::kAnything;
    entry.holds = entry.mixed ? Holds::kAnything : as;
  }
  void UsePorts() const {
    if (model.kind == "SubTree") return;
    std::map<std::string, std::string> ports = model.ports;
    if (model.kind == "Use") ports.insert({{"in", "{x}"}, {"keeps", "{y}"}});
    for (const auto& [port, value] : ports) {
      const auto key = KeyIn(value);
      const auto type = key ? TypeOfPort(model.kind, port) : std::nullopt;
      if (type) Use(*key, *type);
    }
    const auto value = KeyIn(model.value);
    if (value) Use(*value, IsLoop(model.kind) ? TypeOfLoop(model.kind) : Holds::kAnything);
  }

  // The result in place of a tick.
  std::optional<Status> Before() {
    const auto holds = [this](const char* when) {
      const auto found = model.scripts.find(when);
      return found == model.scripts.end() ? std::nullopt : std::optional(True(found->second));
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
  Status After(Status status) {
    if (status == Status::kSuccess) RunScript("_onSuccess");
    if (status == Status::kFailure) RunScript("_onFailure");
    if (IsCompleted(status)) RunScript("_post");
    return status;
  }
  void RunScript(const char* when) {
    const auto found = model.scripts.find(when);
    if (found != model.scripts.end()) Evaluate(found->second, *this);
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
    if (!until_ms_) until_ms_ = node_.world.now_ms + node_.Milliseconds("msec");
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

// A count of children: -1 is all of them.
int CountOf(const Node& node, const std::string& port) {
  const int children = static_cast<int>(node.children.size());
  const int count = node.Number(port);
  if (count > children) throw Broken("is more than the number of its children");
  return count >= 0 ? count : static_cast<int>(std::max(0L, children + 1L + count));
}

class ParallelRun : public Run {
 public:
  explicit ParallelRun(Node& node) : node_(node), ended_(node.children.size()) {}
  Status Tick() override {
    const int all = static_cast<int>(node_.children.size());
    const bool counts_skipped = node_.Number("success_count") < 0;
    const int needed = CountOf(node_, "success_count");
    const int allowed = CountOf(node_, "failure_count");
    int skipped = 0;
    for (std::size_t i = 0; i < node_.children.size(); ++i) {
      if (!ended_[i]) {
        const Status status = node_.children[i]->Tick();
        if (IsCompleted(status)) ended_[i] = status;
        if (status == Status::kSkipped) ++skipped;
      }
      const int successes = Ended(Status::kSuccess);
      const int failures = Ended(Status::kFailure);
      const bool enough = successes + (counts_skipped ? skipped : 0) >= needed;
      if (enough && skipped < all) return Status::kSuccess;
      if (failures == allowed || all - failures < needed) return Status::kFailure;
    }
    return skipped == all ? Status::kSkipped : Status::kRunning;
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
    const int most = CountOf(node_, "max_failures");
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

// Its cases are compared as texts, as numbers and by the names of enums.
class SwitchRun : public Run {
 public:
  explicit SwitchRun(Node& node) : node_(node) {}
  Status Tick() override {
    const auto variable = TextAt("variable");
    std::size_t chosen = 0;
    while (chosen + 1 < node_.children.size()) {
      const auto value = TextAt("case_" + std::to_string(chosen + 1));
      if (variable && value && IsSame(*variable, *value)) break;
      ++chosen;
    }
    for (std::size_t i = 0; i < node_.children.size(); ++i) {
      if (i != chosen) node_.children[i]->Halt();
    }
    return node_.children[chosen]->Tick();
  }

 private:
  // Nothing: the port is left out, or its entry has no value.
  std::optional<std::string> TextAt(const std::string& port) const {
    const auto value = node_.ValueOf(port);
    const auto key = value ? KeyIn(*value) : std::nullopt;
    if (!key) return value;
    const auto& there = node_.Entry(*key).value;
    return there ? std::optional(TextOf(*there)) : std::nullopt;
  }
  static bool IsSame(const std::string& a, const std::string& b) {
    return a == b || (NumberIn(a) && NumberIn(a) == NumberIn(b));
  }
  Node& node_;
};

// The child whose name stands in s, to its end.
class ManualSelectorRun : public Run {
 public:
  explicit ManualSelectorRun(Node& node) : node_(node) {}
  Status Tick() override {
    if (chosen_ == nullptr) {
      const auto& selection = node_.Entry("s").value;
      const std::string wanted = selection ? TextOf(*selection) : "";
      if (wanted == "SUCCESS" || wanted == "FAILURE") {
        node_.Set("s", "");
        return StatusOf(wanted);
      }
      chosen_ = Named(wanted);
      if (chosen_ != nullptr) node_.Set("s", "");
      if (wanted.empty() && node_.IsTrue("repeat_last_selection")) chosen_ = node_.selected;
      if (chosen_ == nullptr) return Status::kRunning;
      node_.selected = chosen_;
    }
    return chosen_->Tick();
  }

 private:
  Node* Named(const std::string& name) const {
    for (const auto& child : node_.children) {
      const Model& model = child->model;
      const std::string& kind = model.id.empty() ? model.kind : model.id;
      if (name == (model.name.empty() ? kind : model.name)) return child.get();
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
  // `port`: of the number of rounds, which is read once in each tick.
  AgainRun(Node& node, Status again, std::string port)
      : node_(node), again_(again), port_(std::move(port)) {}
  Status Tick() override {
    const int limit = node_.Number(port_);
    while (limit == -1 || node_.rounds < limit) {
      Node& child = *node_.children[0];
      const bool ran = child.run != nullptr;
      const Status status = child.Tick();
      if (!IsCompleted(status)) return status;
      if (status != again_) return End(status);
      ++node_.rounds;
      const bool last = limit != -1 && node_.rounds >= limit;
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
  const std::string port_;
};

class DelayRun : public Run {
 public:
  explicit DelayRun(Node& node) : node_(node) {}
  Status Tick() override {
    if (!until_ms_) until_ms_ = node_.world.now_ms + node_.Milliseconds("delay_msec");
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
    if (!limit_ms_) limit_ms_ = node_.Milliseconds("msec");
    const bool over = *limit_ms_ > 0 && node_.world.now_ms - begun_ms_ >= *limit_ms_;
    return over ? Status::kFailure : node_.children[0]->Tick();
  }

 private:
  Node& node_;
  std::optional<std::int64_t> limit_ms_;
  const std::int64_t begun_ms_;
};

class RunOnceRun : public Run {
 public:
  explicit RunOnceRun(Node& node) : node_(node) {}
  Status Tick() override {
    if (node_.result) {
      return node_.IsTrue("then_skip") ? Status::kSkipped : *node_.result;
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
    if (child.run == nullptr && !node_.True(*node_.model.code)) {
      return StatusOf(node_.model.ports.at("else"));
    }
    return child.Tick();
  }

 private:
  Node& node_;
};

class LoopRun : public Run {
 public:
  explicit LoopRun(Node& node) : node_(node), holds_(TypeOfLoop(node.model.kind)) {}
  Status Tick() override {
    if (!values_) values_ = Values();
    Node& child = *node_.children[0];
    if (child.run == nullptr) {
      if (round_ == values_->size()) return StatusOf(node_.model.ports.at("if_empty"));
      node_.Set(KeyIn(node_.model.value).value(), (*values_)[round_++]);
    }
    return child.Tick() == Status::kFailure ? Status::kFailure : Status::kRunning;
  }

 private:
  // Those of the queue when the loop starts.
  std::vector<Datum> Values() const {
    std::vector<std::string> parts = node_.model.queue;
    if (node_.model.ports.contains("queue")) {
      const Datum queue = node_.Read("queue", Holds::kAnything);
      if (!std::holds_alternative<std::string>(queue)) throw Broken("is not of the port's type");
      std::stringstream text(std::get<std::string>(queue));
      for (std::string part; std::getline(text, part, ';');) parts.push_back(part);
    }
    std::vector<Datum> values;
    for (const std::string& part : parts) {
      const auto value = As(holds_, part);
      if (!value) throw Broken("is not of the port's type");
      values.push_back(*value);
    }
    return values;
  }

  Node& node_;
  const Holds holds_;
  std::optional<std::vector<Datum>> values_;
  std::size_t round_ = 0;
};

// Whether the entry was set since the last look of this node at it.
bool WasSet(Node& node) {
  const int sets = node.Entry(KeyIn(node.model.ports.at("entry")).value()).sets;
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

void SetBlackboard(Node& node) {
  const auto from = KeyIn(node.model.value);
  node.Set(node.model.ports.at("output_key"), from ? node.Value(*from) : Datum(node.model.value));
}

void UnsetBlackboard(const Node& node) {
  const std::string& key = node.model.ports.at("key");
  if (!kEntries.contains(key)) return;  // another entry of the tree, which no node reads
  node.Entry(key).value.reset();
  node.Entry(key).declared = false;
}

void UsePort(Node& node) {
  const int in = node.Number("in");
  node.world.log += node.model.name + "=" + std::to_string(in) + " ";
  node.Write("out", in % 1000 + 1.0);
  node.Write("keeps", node.Number("keeps") % 1000 + in % 1000 + 0.0);
}

void PrintText(Node& node) {
  const std::string what = std::get<std::string>(node.Read("what", Holds::kText));
  node.world.log += node.model.name + "='" + what + "' ";
  node.Write("to", what.size() < 9 ? what + "." : "");
}

void CarryPlace(Node& node) {
  const std::string place = std::get<std::string>(node.Read("place", Holds::kPlace));
  node.world.log += node.model.name + "=" + place + " ";
  const std::size_t at = place.find(';');
  node.Write("to", std::to_string(std::stoi(place) % 1000 + 1) + place.substr(at));
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
  if (auto leaf = StartLeaf()) return leaf;
  auto control = StartControl();
  return control != nullptr ? std::move(control) : StartDecorator();
}

// Of a leaf whose ticks end at once. Null: it is none.
std::unique_ptr<Run> Node::StartLeaf() {
  const std::string& kind = model.kind;
  const auto at_once = [](Status status, std::function<void()> what) {
    return std::make_unique<AtOnceRun>([status, what = std::move(what)] {
      what();
      return status;
    });
  };
  const auto whether = [](std::function<bool()> what) {
    return std::make_unique<AtOnceRun>(
        [what = std::move(what)] { return what() ? Status::kSuccess : Status::kFailure; });
  };
  if (kind == "AlwaysSuccess") return at_once(Status::kSuccess, [] {});
  if (kind == "AlwaysFailure") return at_once(Status::kFailure, [] {});
  if (kind == "Script") {
    return at_once(Status::kSuccess, [this] { Evaluate(*model.code, *this); });
  }
  if (kind == "ScriptCondition") return whether([this] { return True(*model.code); });
  if (kind == "SetBlackboard") return at_once(Status::kSuccess, [this] { SetBlackboard(*this); });
  if (kind == "UnsetBlackboard") {
    return at_once(Status::kSuccess, [this] { UnsetBlackboard(*this); });
  }
  if (kind == "WasEntryUpdated" || kind == "EntryUpdated") {
    return whether([this] { return WasSet(*this); });
  }
  if (kind == "Use") return at_once(Status::kSuccess, [this] { UsePort(*this); });
  if (kind == "Print") return at_once(Status::kSuccess, [this] { PrintText(*this); });
  if (kind == "Carry") return at_once(Status::kSuccess, [this] { CarryPlace(*this); });
  return nullptr;
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
    return std::make_unique<AgainRun>(*this, Status::kSuccess, "num_cycles");
  }
  if (kind == "RetryUntilSuccessful") {
    return std::make_unique<AgainRun>(*this, Status::kFailure, "num_attempts");
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
  Node::Keys own;
  for (const auto& [entry, value] : kEntries) {
    own[entry] = entry;
    board.try_emplace(entry);
  }
  root_ = std::make_unique<Node>(main, *this, own);
  for (const auto& [entry, value] : kEntries) Set(entry, value);
  // A number where the whole text is one, or the type of its ports.
  for (const auto& [entry, text] : constants) {
    const auto number = NumberIn(text);
    Set(entry, number ? Datum(*number) : Datum(text));
  }
}

Interpreter::~Interpreter() = default;

// Where a node fails, also in its halt, every running node is halted once.
Outcome Interpreter::Tick(std::int64_t at_ms) {
  now_ms = std::max(now_ms, at_ms);
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
  now_ms = std::max(now_ms, at_ms);
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

void Interpreter::Set(const std::string& entry, const Datum& value) {
  BoardEntry& there = board.at(entry);
  there.value = As(there.holds, value).value();
  ++there.sets;
}

void Interpreter::Restore(const std::map<std::string, BoardEntry>& backup) {
  for (const auto& [entry, was] : backup) {
    if (was.value) {
      Set(entry, *was.value);
    } else {
      board.at(entry).value.reset();
    }
  }
}

std::vector<bool> Interpreter::Running() const {
  std::vector<bool> all;
  root_->Running(all);
  return all;
}

}  // namespace musher::tree::conformance
