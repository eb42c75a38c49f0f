// Random trees in the engine and in an interpreter that was written from the documentation
// (interpreter.hpp): in each tick the same result, calls of the leaves, entries and running nodes;
// where a node fails, the same node with its path, and the same halts. In a third of the trees
// nodes fail: in a tick, in a halt, by a result that is none, in a script or a port whose entry has
// no value, or one that does not fit. Between ticks the tree is halted, entries are set, saved and
// restored, and the clock goes back.
//
// MUSHER_SEEDS=1000000 tries more of them. Of those that differ, the smallest is shown.

#include <algorithm>
#include <cstdlib>
#include <set>
#include <stdexcept>

#include "musher/behavior/tree/backup.hpp"
#include "musher/behavior/tree/factory.hpp"
#include "musher/behavior/tree/json/json_fields.hpp"
#include "musher/test/behavior/tree/conformance/generator.hpp"
#include "musher/test/behavior/tree/trees.hpp"
#include "musher/test/support/nightly.hpp"

namespace musher::tree::conformance_random_trees_test {

using conformance::Datum;
using conformance::Expression;
using conformance::Failure;
using conformance::Generator;
using conformance::Interpreter;
using conformance::kEntries;
using conformance::kEnums;
using conformance::Model;
using conformance::Outcome;
using conformance::TextOf;

// What the leaves have in common.
struct Robot {
  std::string log;
  std::vector<WakeUp> wake_ups;  // of each Say
};

// The result of a tick by its letter; see interpreter.hpp.
Status ResultOf(char letter) {
  switch (letter) {
    case '!':
      throw std::runtime_error("it broke");
    case '*':
      throw 42;  // NOLINT(misc-throw-by-value-catch-by-reference,hicpp-exception-baseclass)
    case '?':
      return static_cast<Status>(99);
    case 'I':
      return Status::kIdle;
    case 'S':
      return Status::kSuccess;
    case 'F':
      return Status::kFailure;
    case '-':
      return Status::kSkipped;
    default:
      return Status::kRunning;
  }
}

// What a leaf does in its ticks.
class Routine {
 public:
  Routine(Setup& setup, Robot& robot)
      : name_(setup.name()), does_(setup.Input<std::string>("does")), robot_(robot) {}
  // Logs the name, with `how` behind it. The letter of this tick.
  char Next(const std::string& how) {
    const std::string& does = does_.Get();
    Log(how);
    return does[ticks_++ % does.size()];
  }
  void Log(const std::string& how) { robot_.log += name_ + how; }

 private:
  const std::string name_;
  InPort<std::string> does_;
  Robot& robot_;
  std::size_t ticks_ = 0;
};

class Say : public StatefulAction {
 public:
  Say(Setup& setup, Robot& robot)
      : routine_(setup, robot),
        halts_(setup.OptionalInput<std::string>("halts")),
        wake_up_(setup.wake_up()) {
    robot.wake_ups.push_back(wake_up_);
  }

 private:
  Status OnStart(const Tick&) override { return Do("^ "); }
  Status OnRunning(const Tick&) override { return Do(" "); }
  void OnHalted(const Tick&) override {
    routine_.Log("! ");
    if (halts_.Find() != nullptr) throw std::runtime_error("its halt broke");
  }
  Status Do(const std::string& how) {
    const char letter = routine_.Next(how);
    if (letter == 'w') wake_up_.Request();
    return ResultOf(letter);
  }

  Routine routine_;
  InPort<std::string> halts_;
  WakeUp wake_up_;
};

// A leaf whose ticks end at once.
template <class Leaf>
class Short : public Leaf {
 public:
  Short(Setup& setup, Robot& robot) : routine_(setup, robot) {}

 protected:
  Status Next() { return ResultOf(routine_.Next(" ")); }

 private:
  Routine routine_;
};

class Act : public Short<Action> {
  using Short::Short;
  Status Do(const Tick&) override { return Next(); }
};

class Look : public Short<Condition> {
  using Short::Short;
  Status Evaluate(const Tick&) override { return Next(); }
};

// Logs the whole number that it reads; see interpreter.hpp.
class Use : public Action {
 public:
  Use(Setup& setup, Robot& robot)
      : name_(setup.name()),
        in_(setup.Input<int>("in", FromEntry{"x"})),
        out_(setup.Output<int>("out")),
        keeps_(setup.InOut<int>("keeps", FromEntry{"y"})),
        robot_(robot) {}

 private:
  Status Do(const Tick&) override {
    const int in = in_.Get();
    robot_.log += name_ + "=" + std::to_string(in) + " ";
    out_.Set(in % kBelow + 1);
    keeps_.Set(keeps_.Get() % kBelow + in % kBelow);
    return Status::kSuccess;
  }
  static constexpr int kBelow = 1000;
  const std::string name_;
  InPort<int> in_;
  OutPort<int> out_;
  InOutPort<int> keeps_;
  Robot& robot_;
};

class Print : public Action {
 public:
  Print(Setup& setup, Robot& robot)
      : name_(setup.name()),
        what_(setup.Input<std::string>("what")),
        to_(setup.Output<std::string>("to")),
        robot_(robot) {}

 private:
  Status Do(const Tick&) override {
    const std::string what = what_.Get();
    robot_.log += name_ + "='" + what + "' ";
    to_.Set(what.size() < kLongest ? what + "." : "");
    return Status::kSuccess;
  }
  static constexpr std::size_t kLongest = 9;
  const std::string name_;
  InPort<std::string> what_;
  OutPort<std::string> to_;
  Robot& robot_;
};

struct Place {
  int x = 0;
  int y = 0;
  std::string Text() const { return std::to_string(x) + ";" + std::to_string(y); }
};

}  // namespace musher::tree::conformance_random_trees_test

template <>
struct musher::tree::Convert<musher::tree::conformance_random_trees_test::Place>
    : musher::tree::JsonFields<musher::tree::conformance_random_trees_test::Place> {
  static constexpr std::string_view kName = "Place";
  static void Fields(auto& json, auto& place) {
    json("x", place.x);
    json("y", place.y);
  }
  static Result<conformance_random_trees_test::Place> FromText(std::string_view text) {
    const auto numbers = Convert<std::vector<int>>::FromText(text);
    if (!numbers || numbers.value().size() != 2) return NoValue(text, "a place \"x;y\"");
    return conformance_random_trees_test::Place{numbers.value()[0], numbers.value()[1]};
  }
};

namespace musher::tree::conformance_random_trees_test {

class Carry : public Action {
 public:
  Carry(Setup& setup, Robot& robot)
      : name_(setup.name()),
        place_(setup.Input<Place>("place")),
        to_(setup.Output<Place>("to")),
        robot_(robot) {}

 private:
  Status Do(const Tick&) override {
    const Place place = place_.Get();
    robot_.log += name_ + "=" + place.Text() + " ";
    to_.Set({place.x % kBelow + 1, place.y});
    return Status::kSuccess;
  }
  static constexpr int kBelow = 1000;
  const std::string name_;
  InPort<Place> place_;
  OutPort<Place> to_;
  Robot& robot_;
};

// What the trees have had.
struct Seen {
  std::set<std::string> kinds{};      // of nodes
  std::set<std::string> operators{};  // of scripts
  int ticks = 0;                      // of trees whose nodes do not fail
  int faults = 0;                     // of these: errors of scripts and ports
};

void CollectOperators(const Expression& expression, std::set<std::string>& operators) {
  const bool is_sign = expression.what == "-" && expression.of.size() == 1;
  if (!expression.of.empty()) operators.insert(is_sign ? "sign" : expression.what);
  operators.insert(expression.signs.begin(), expression.signs.end());
  for (const Expression& each : expression.of) CollectOperators(each, operators);
}
void Collect(const Model& model, Seen& seen) {
  seen.kinds.insert(model.kind);
  if (model.code) CollectOperators(*model.code, seen.operators);
  for (const auto& [when, script] : model.scripts) CollectOperators(script, seen.operators);
  for (const Model& child : model.children) Collect(child, seen);
}

std::string TextOf(const std::vector<bool>& running) {
  std::string text;
  for (const bool each : running) text += each ? 'R' : '.';
  return text;
}

// "S n0^ n1 | b=0 d=0 s= x=1 y=0 z=- | R..R", "! node 3: it broke n0^ n1 | ..."
std::string ShownOf(const std::string& result, const std::string& log,
                    const std::map<std::string, std::string>& entries,
                    const std::vector<bool>& running) {
  std::string text = result + " " + log + "|";
  for (const auto& [entry, value] : entries) text += " " + entry + "=" + value;
  return text + " | " + TextOf(running);
}
std::string TextOf(const Failure& failure) {
  return "! node " + std::to_string(failure.node) + ": " + failure.why;
}
std::string Shown(const Datum& datum) {
  return std::holds_alternative<std::string>(datum) ? "'" + TextOf(datum) + "'" : TextOf(datum);
}
std::string ShownOf(Interpreter& interpreter, const Outcome& outcome) {
  std::map<std::string, std::string> entries;
  for (const auto& [entry, value] : kEntries) {
    const auto& there = interpreter.board.at(entry).value;
    entries[entry] = there ? Shown(*there) : "-";
  }
  const std::string result =
      outcome.failure ? TextOf(*outcome.failure) : std::string(1, Letter(outcome.status));
  return ShownOf(result, std::exchange(interpreter.log, ""), entries, interpreter.Running());
}
// "-": there is no value.
std::string ShownOf(const Entry* entry) {
  double number = 0;
  if (entry == nullptr || entry->value.empty()) return "-";
  if (const auto* place = entry->value.As<Place>()) return Shown(place->Text());
  if (const auto* text = entry->value.Text()) return Shown(*text);
  return entry->value.ToNumber(number) ? Shown(number) : "?";
}

// The message has the place and the path of the node, and why it failed.
bool Names(const Tree& tree, const Failure& failure, const std::string& message) {
  const auto node = static_cast<NodeId>(failure.node);
  return message.starts_with(tree.PlaceOf(node) + ": " + tree.Path(node) + ": ") &&
         message.find(failure.why) != std::string::npos;
}

// `expected`: how its error is shown, if it is the expected one.
std::string ShownOf(Tree& tree, const std::string& log, const Result<Status>& status,
                    const Outcome& expected) {
  std::map<std::string, std::string> entries;
  for (const auto& [entry, value] : kEntries) entries[entry] = ShownOf(tree.board().Find(entry));
  std::vector<bool> running;
  for (NodeId id = 0; id < tree.size(); ++id)
    running.push_back(tree.status(id) == Status::kRunning);
  std::string result(1, Letter(status));
  if (!status) {
    const std::string& message = status.error().message;
    result = expected.failure && Names(tree, *expected.failure, message) ? TextOf(*expected.failure)
                                                                         : message;
  }
  return ShownOf(result, log, entries, running);
}

// A tree in the engine and in the interpreter.
class Both {
 public:
  Both(const Model& model, Generator& random)
      : document_(DocumentOf(model)), random_(random), interpreter_(model) {
    EXPECT_TRUE(factory_.Add<Say>("Say", robot_));
    EXPECT_TRUE(factory_.Add<Act>("Act", robot_));
    EXPECT_TRUE(factory_.Add<Look>("Look", robot_));
    EXPECT_TRUE(factory_.Add<Use>("Use", robot_));
    EXPECT_TRUE(factory_.Add<Print>("Print", robot_));
    EXPECT_TRUE(factory_.Add<Carry>("Carry", robot_));
    for (const auto& [name, number] : kEnums) factory_.AddEnum(name, number);
    tree_ = MakeTree(document_, factory_);
    if (tree_ == nullptr) return;
    tree_->OnWakeUp([this] { robot_.log += "~ "; });
    for (const auto& [entry, value] : kEntries) SetInTree(entry, value);
  }
  static std::vector<std::string> Kinds() {
    std::vector<std::string> kinds = Factory().Names();
    kinds.insert(kinds.end(), {"Say", "Act", "Look", "Use", "Print", "Carry", "SubTree"});
    return kinds;
  }

  int ticks() const { return ticks_; }
  int faults() const { return faults_; }
  // Where both differ; "" for nowhere.
  std::string Difference() {
    if (tree_ == nullptr) return "the tree is not built:\n" + document_;
    for (int i = 0; i < 30 && found_.empty(); ++i) {
      BetweenTicks();
      const bool once = random_.OneIn(3);
      const std::int64_t now_ms = at_ms_ - (random_.OneIn(20) ? 20 : 0);  // a clock that goes back
      const auto status = once ? tree_->TickOnce(At(now_ms)) : tree_->TickExactlyOnce(At(now_ms));
      const Outcome outcome = once ? interpreter_.TickOnce(now_ms) : interpreter_.Tick(now_ms);
      Compare(once ? "once " : "", status, outcome);
      ++ticks_;
      if (outcome.failure) ++faults_;
      at_ms_ += 10 * random_.Number(0, 2);
    }
    return found_;
  }

 private:
  // A person, a program, the robot.
  void BetweenTicks() {
    if (random_.OneIn(10)) {
      const Result<> halted = tree_->Halt(At(at_ms_));
      const Outcome outcome = interpreter_.Halt(at_ms_);
      Compare("halt ", halted ? Result<Status>(Status::kIdle) : halted.error(), outcome);
    }
    if (random_.OneIn(8)) Set("s", random_.Selection());
    if (random_.OneIn(12)) Set(random_.OneIn(2) ? "x" : "n", 0.0 + random_.Number(-1, 4));
    if (random_.OneIn(20)) {
      backup_ = std::make_unique<Backup>(*tree_);
      backup_of_interpreter_ = interpreter_.Backup();
      before_ += "a backup\n";
    }
    if (random_.OneIn(20) && backup_ != nullptr) {
      EXPECT_TRUE(backup_->Restore(*tree_));
      interpreter_.Restore(backup_of_interpreter_);
      before_ += "restored\n";
    }
    if (random_.OneIn(8) && !robot_.wake_ups.empty()) {
      robot_.wake_ups.back().Request();
      interpreter_.WakeUp();
      before_ += "a wake-up\n";
    }
  }
  void Set(const std::string& entry, const Datum& value) {
    SetInTree(entry, value);
    interpreter_.Set(entry, value);
    before_ += entry + " := " + Shown(value) + "\n";
  }
  void SetInTree(const std::string& entry, const Datum& value) {
    const auto* const text = std::get_if<std::string>(&value);
    Board& board = tree_->board();
    EXPECT_TRUE(text != nullptr ? board.Set(entry, text->c_str())
                : entry == "b"  ? board.Set(entry, std::get<double>(value) != 0)
                                : board.Set(entry, static_cast<int>(std::get<double>(value))));
  }
  void Compare(const std::string& what, const Result<Status>& status, const Outcome& outcome) {
    const std::string engine = ShownOf(*tree_, std::exchange(robot_.log, ""), status, outcome);
    const std::string expected = ShownOf(interpreter_, outcome);
    if (engine != expected && found_.empty()) {
      found_ = document_ + before_ + "expected of " + what + "at " + std::to_string(at_ms_) +
               " ms: " + expected + "\nthe engine:     " + engine;
    }
    before_ += what + std::to_string(at_ms_) + " ms: " + expected + "\n";
  }

  const std::string document_;
  Generator& random_;
  Robot robot_;
  Factory factory_;
  Interpreter interpreter_;
  std::unique_ptr<Tree> tree_;
  std::unique_ptr<Backup> backup_;
  std::map<std::string, conformance::BoardEntry> backup_of_interpreter_;
  std::string before_;
  std::string found_;
  std::int64_t at_ms_ = 0;
  int ticks_ = 0;
  int faults_ = 0;  // of these
};

TEST(RandomTreesAsDocumented, BehaveAsInTheInterpreter) {
  const char* const wanted = std::getenv("MUSHER_SEEDS");
  const std::uint32_t count =
      std::max(testing::Nightly() ? 100'000U : 2'000U,
               wanted == nullptr ? 0U : static_cast<std::uint32_t>(std::stoul(wanted)));
  Seen seen;
  std::string smallest;  // of the differences
  for (std::uint32_t seed = 0; seed < count; ++seed) {
    Generator random(seed);
    const Model model = random.Tree();
    Collect(model, seen);
    Both both(model, random);
    const std::string difference = both.Difference();
    if (!random.fails()) {
      seen.ticks += both.ticks();
      seen.faults += both.faults();
    }
    if (difference.empty()) continue;
    const std::string found = "seed " + std::to_string(seed) + ":\n" + difference;
    if (smallest.empty() || found.size() < smallest.size()) smallest = found;
  }
  EXPECT_EQ(smallest, "");
  EXPECT_THAT(seen.kinds, ::testing::UnorderedElementsAreArray(Both::Kinds()))
      << "each node that Musher has, and nothing else";
  EXPECT_THAT(seen.operators, ::testing::UnorderedElementsAre(
                                  ":=", "=", "+=", "-=", "*=", "/=", "?:", "||", "&&", "<>",
                                  "==", "!=", "<", ">", "<=", ">=", "|", "^", "&", "..", "+", "-",
                                  "*", "/", "!", "~", "sign", "()", ";"));
  EXPECT_LT(seen.faults * 10, seen.ticks) << "too many trees end at once";
}

}  // namespace musher::tree::conformance_random_trees_test
