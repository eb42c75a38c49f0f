#include "musher/test/behavior/tree/conformance/generator.hpp"

#include <utility>

namespace musher::tree::conformance {
namespace {

Expression Atom(std::string what) {
  return {.what = std::move(what)};
}
Expression Atom(int number) {
  return Atom(std::to_string(number));
}

}  // namespace

Model Generator::Tree(int depth) {
  Model model = Node(depth);
  for (const char* const when : {"_skipIf", "_failureIf", "_successIf", "_while"}) {
    if (OneIn(18)) model.scripts[when] = Condition();
  }
  for (const char* const when : {"_onSuccess", "_onFailure", "_onHalted", "_onHalted", "_post"}) {
    if (OneIn(18)) model.scripts[when] = Script();
  }
  if (!model.children.empty() && OneIn(10)) model.name = "c" + std::to_string(names_++);
  return model;
}

std::string Generator::Selection() {
  return OneIn(4) ? OneOf({"", "SUCCESS", "FAILURE", "nothing", "Sequence", "Parallel", "Sub0"})
                  : OneOf({"n", "n", "n", "c"}) + std::to_string(Number(0, 5));
}

Model Generator::Node(int depth) {
  const int which = depth == 0 ? 0 : Number(0, 9);
  if (which < 2) return Leaf();
  if (which < 7) return Control(depth - 1);
  return OneIn(6) ? Subtree(depth - 1) : Decorator(depth - 1);
}

// --- leaves ---

Model Generator::Leaf() {
  Model leaf{.kind = OneOf({"Say",
                            "Say",
                            "Say",
                            "Say",
                            "Say",
                            "Say",
                            "Say",
                            "Act",
                            "Look",
                            "Use",
                            "Print",
                            "Carry",
                            "Script",
                            "ScriptCondition",
                            "Sleep",
                            "AlwaysSuccess",
                            "SetBlackboard",
                            "AlwaysFailure",
                            "UnsetBlackboard",
                            "WasEntryUpdated",
                            "EntryUpdated"})};
  AddPorts(leaf);
  return leaf;
}

void Generator::AddPorts(Model& leaf) {
  const std::string& kind = leaf.kind;
  if (kind == "Sleep") leaf.ports["msec"] = Milliseconds();
  if (kind == "Script") leaf.code = Script();
  if (kind == "ScriptCondition") leaf.code = Condition();
  if (kind == "SetBlackboard") AddSetBlackboard(leaf);
  // Where no node is to fail, an entry that no other node uses.
  if (kind == "UnsetBlackboard") {
    leaf.ports["key"] = fails_ ? OneOf({"x", "y", "z", "b", "d", "s", "t", "n", "k", "p"}) : "u";
  }
  if (kind.ends_with("EntryUpdated")) leaf.ports["entry"] = AnyEntry();
  const bool says = kind == "Say" || kind == "Act" || kind == "Look";
  if (!says && kind != "Use" && kind != "Print" && kind != "Carry") return;
  leaf.name = "n" + std::to_string(names_++);
  if (says) leaf.does = Does(kind == "Act");
  if (kind == "Say" && fails_ && OneIn(8)) leaf.ports["halts"] = "!";
  if (kind == "Use") AddUse(leaf);
  if (kind == "Print") {
    leaf.ports["what"] = OneOf({"n1", "{s}", "{t}", "{n}", "{d}", "{x}", "{@n}"});
    if (OneIn(2)) leaf.ports["to"] = fails_ && OneIn(3) ? "{n}" : OneOf({"{s}", "{t}"});
  }
  if (kind == "Carry") {
    leaf.ports["place"] = OneIn(2) ? "{p}" : Place();
    if (OneIn(2)) leaf.ports["to"] = "{p}";
  }
}

void Generator::AddUse(Model& leaf) {
  if (!OneIn(3)) leaf.ports["in"] = OneOf({"{x}", "{y}", "{k}", "{@x}", "3", "RED", "-2"});
  if (fails_ && OneIn(8)) leaf.ports["in"] = "{n}";
  if (OneIn(2)) leaf.ports["out"] = OneOf({"{x}", "{y}"});
  if (!OneIn(3)) leaf.ports["keeps"] = OneOf({"{x}", "{y}", "5"});
}

void Generator::AddSetBlackboard(Model& leaf) {
  const int what = Number(0, fails_ ? 6 : 5);
  std::string& key = leaf.ports["output_key"];
  if (what < 2) {
    key = OneOf({"s", "t"});
    leaf.value = OneOf({"n1", "n3", "1;2", "{s}", "{t}", ""});
    if (leaf.value.empty()) leaf.value = "n0";
  } else if (what < 4) {
    key = OneOf({"x", "y", "z"});
    leaf.value = OneOf({"{x}", "{y}", "{z}", "{k}", "{b}"});
  } else if (what == 4) {
    key = OneOf({"d", "n"});
    leaf.value = "{" + NumberKey() + "}";
  } else if (what == 5) {
    key = "p";
    leaf.value = Place();
  } else {
    key = OneOf({"x", "y", "z", "b", "d", "n", "k", "t", "p"});
    leaf.value = OneOf({"3", "1.5", "n2", "true", "{t}", "{n}", "{_p}"});
  }
}

std::string Generator::Place() {
  const std::string x = std::to_string(Number(0, 3));
  const std::string y = std::to_string(Number(-3, 3));
  return OneIn(2) ? x + ";" + y : R"(json:{"x": )" + x + R"(, "y": )" + y + "}";
}

std::string Generator::AnyEntry() {
  return "{" + OneOf({"x", "y", "z", "b", "d", "s", "t", "n", "k", "@x"}) + "}";
}

std::string Generator::Does(bool at_once) {
  std::string does;
  const int letters = Number(1, 4);
  for (int i = 0; i < letters; ++i) {
    if (fails_ && OneIn(10)) {
      does += OneOf({"!", "*", "?", "I"});
    } else {
      does += at_once && !fails_ ? OneOf({"S", "S", "F", "-"})
                                 : OneOf({"S", "S", "S", "F", "F", "R", "R", "w", "-"});
    }
  }
  return does;
}

// --- controls ---

Model Generator::Control(int depth) {
  Model control{.kind = OneOf({"Sequence", "AsyncSequence", "SequenceWithMemory",
                               "ReactiveSequence", "Fallback", "AsyncFallback", "ReactiveFallback",
                               "Parallel", "ParallelAll", "IfThenElse", "WhileDoElse", "Switch",
                               "Switch", "TryCatch", "Finally", "ManualSelector"})};
  const std::string kind = control.kind;
  const int count = ChildrenOf(kind);
  auto& ports = control.ports;
  if (kind == "Switch") {
    control.kind += std::to_string(count - 1);
    AddCases(count - 1, control);
  }
  if (kind == "Parallel") {
    if (!OneIn(12)) ports["success_count"] = Count(-2, count);
    if (!OneIn(12)) ports["failure_count"] = Count(-2, count);
  }
  if (kind == "ParallelAll" && !OneIn(12)) ports["max_failures"] = Count(-1, count);
  if (kind == "TryCatch") ports["catch_on_halt"] = OneOf({"true", "false"});
  if (kind == "ManualSelector") {
    ports["selection"] = "{s}";
    ports["repeat_last_selection"] = Bool();
  }
  for (int i = 0; i < count; ++i) control.children.push_back(Tree(depth));
  return control;
}

int Generator::ChildrenOf(const std::string& kind) {
  if (kind == "Finally") return 2;
  if (kind == "IfThenElse" || kind == "WhileDoElse") return Number(2, 3);
  if (kind == "Switch") return OneIn(2) || narrow_ ? Number(3, 4) : Number(5, 7);
  const int most = narrow_ ? 2 : OneIn(12) ? 8 : 4;
  return Number(kind == "TryCatch" ? 2 : 1, most);
}

// Of children, or of rounds.
std::string Generator::Count(int from, int to) {
  if (OneIn(fails_ ? 5 : 10)) return OneOf({"{x}", "{y}", "{k}", "{@x}"});
  return std::to_string(Number(from, to));
}

void Generator::AddCases(int cases, Model& control) {
  const bool of_text = OneIn(3);
  if (!OneIn(10)) {
    control.ports["variable"] = of_text ? OneOf({"{s}", "{t}"}) : OneOf({"{x}", "{x}", "{n}", "2"});
  }
  for (int i = 1; i <= cases; ++i) {
    if (OneIn(8)) continue;
    std::string& value = control.ports["case_" + std::to_string(i)];
    value = of_text ? "n" + std::to_string(Number(0, 5)) : std::to_string(Number(0, 3));
    if (OneIn(6)) value = OneOf({"2.0", "RED", "BLUE", "0.5"});
    if (i < 3 && OneIn(8)) value = OneOf({"{y}", "{t}"});
  }
}

// --- decorators ---

Model Generator::Decorator(int depth) {
  Model decorator{
      .kind = OneOf({"Inverter", "ForceSuccess", "ForceFailure", "Repeat", "RetryUntilSuccessful",
                     "KeepRunningUntilFailure", "Delay", "Timeout", "RunOnce", "Precondition",
                     "Loop", "Loop", "SkipUnlessUpdated", "WaitValueUpdate"})};
  const std::string& kind = decorator.kind;
  auto& ports = decorator.ports;
  if (kind == "Repeat") ports["num_cycles"] = Count(-1, 3);
  if (kind == "RetryUntilSuccessful") ports["num_attempts"] = Count(-1, 3);
  if (kind == "Delay") ports["delay_msec"] = Milliseconds();
  if (kind == "Timeout") ports["msec"] = Milliseconds();
  if (kind == "RunOnce") ports["then_skip"] = Bool();
  if (kind == "Precondition") {
    decorator.code = Condition();
    ports["else"] = OneOf({"SUCCESS", "FAILURE", "RUNNING", "SKIPPED"});
  }
  if (kind.ends_with("Update") || kind.ends_with("Updated")) ports["entry"] = AnyEntry();
  if (kind == "Loop") AddLoop(decorator);
  decorator.children.push_back(Tree(depth));
  return decorator;
}

void Generator::AddLoop(Model& loop) {
  const std::string of = OneOf({"Int", "Bool", "Double", "String"});
  loop.kind += of;
  loop.value = of == "Int" ? "{x}" : of == "Bool" ? "{b}" : of == "Double" ? "{d}" : "{s}";
  if (OneIn(of == "String" || fails_ ? 4 : 20)) {
    loop.ports["queue"] = OneOf({"{t}", "{s}"});
  } else {
    const int values = Number(0, 3);
    for (int i = 0; i < values; ++i) {
      loop.queue.push_back(of == "Bool"     ? OneOf({"true", "false", "1", "0"})
                           : of == "String" ? "n" + std::to_string(Number(0, 5))
                           : of == "Double" ? OneOf({"0", "1.5", "-2"})
                                            : std::to_string(Number(-1, 3)));
    }
  }
  loop.ports["if_empty"] = OneOf({"SUCCESS", "FAILURE", "SKIPPED"});
}

// --- subtrees ---

Model Generator::Subtree(int depth) {
  Model subtree{.kind = "SubTree"};
  if (!subtrees_.empty() && OneIn(4)) {
    const auto which = Number(0, static_cast<int>(subtrees_.size()) - 1);
    const Model& other = subtrees_[static_cast<std::size_t>(which)];
    subtree.id = other.id;
    subtree.defaults = other.defaults;
    subtree.children = other.children;
  } else {
    subtree.children.push_back(Tree(depth));
    subtree.id = "Sub" + std::to_string(subtrees_.size());
    if (OneIn(4)) subtree.defaults["k"] = OneOf({"2", "{x}", "{k}", "RED"});
    if (OneIn(6)) subtree.defaults["y"] = OneOf({"{x}", "{y}"});
    subtrees_.push_back(subtree);
  }
  AddKeys(subtree);
  return subtree;
}

void Generator::AddKeys(Model& subtree) {
  const bool remaps = OneIn(3);
  if (remaps) subtree.ports["_autoremap"] = "true";
  if (OneIn(3)) subtree.fixed["k"] = OneIn(4) ? "BLUE" : std::to_string(Number(0, 3));
  if (!remaps) {
    for (const auto& [key, value] : kEntries) {
      if (key.starts_with('_') || subtree.fixed.contains(key)) continue;
      if (subtree.defaults.contains(key) && OneIn(2)) continue;
      subtree.entries[key] = key;
    }
  }
  if (OneIn(3)) {
    subtree.entries["x"] = "y";
    subtree.entries["y"] = "x";
  }
  if (OneIn(4)) {
    subtree.entries["s"] = "t";
    subtree.entries["t"] = "s";
  }
  if (OneIn(8)) subtree.entries["x"] = "n";
  // Of its own, without a value.
  if (fails_ && OneIn(3)) subtree.entries.erase(OneOf({"y", "n", "t", "k", "p", "z"}));
}

// --- scripts ---

std::string Generator::WholeKey() {
  if (OneIn(8)) return OneOf({"@x", "@y"});
  return OneOf({"x", "x", "y", "y", "z", "k", "b"});
}

std::string Generator::NumberKey() {
  if (fails_ && OneIn(20)) return OneOf({"_p", "t"});
  return OneIn(3) ? OneOf({"d", "n", "n", "@n"}) : WholeKey();
}

std::string Generator::TextConstant() {
  return "'" + OneOf({"n0", "n1", "n2", "", "1;2", "n3;n4", "true", "2", "RED", "SUCCESS"}) + "'";
}

Expression Generator::Constant(bool whole) {
  if (OneIn(3)) return Atom(OneOf({"0x1F", "RED", "GREEN", "BLUE", "true", "false", "1e2"}));
  if (!whole && OneIn(2)) return Atom(OneOf({"1.5", "0.25", "2.75"}));
  return Atom(Number(0, 3));
}

// A number.
Expression Generator::Amount(int depth, bool whole) {
  if (depth > 0 && !OneIn(3)) return Operation(depth - 1, whole);
  return OneIn(2) ? Constant(whole) : Atom(whole ? WholeKey() : NumberKey());
}

Expression Generator::Operation(int depth, bool whole) {
  const std::string sign =
      OneOf({"+", "-", "+", "-", "*", "/", "&", "|", "^", "~", "sign", "()", "?:", "<>"});
  const auto amount = [&] { return Amount(depth, whole); };
  if (sign == "<>") return Truth(depth);
  if (sign == "?:") {
    Expression condition = Truth(depth);
    Expression yes = amount();
    return {"?:", {std::move(condition), std::move(yes), amount()}};
  }
  if (sign == "sign") return {"-", {amount()}};
  if (sign == "()") return {"()", {amount()}};
  if (sign == "~") return {"~", {Amount(depth, true)}};
  if (sign == "*") return {"*", {amount(), Atom(Number(0, 2))}};
  if (sign == "/") return whole ? amount() : Expression{"/", {amount(), Atom(OneOf({"2", "4"}))}};
  const bool bits = sign == "&" || sign == "|" || sign == "^";
  Expression first = Amount(depth, whole || bits);
  return {sign, {std::move(first), Amount(depth, whole || bits)}};
}

Expression Generator::Truth(int depth) {
  if (depth == 0) return OneIn(4) ? Atom(OneOf({"b", "true", "false"})) : Chain(0);
  const std::string sign = OneOf({"<>", "<>", "<>", "&&", "||", "!", "()"});
  if (sign == "<>") return Chain(depth - 1);
  Expression first = Truth(depth - 1);
  if (sign == "!" || sign == "()") return {sign, {std::move(first)}};
  return {sign, {std::move(first), Truth(depth - 1)}};
}

Expression Generator::Chain(int depth) {
  const auto sign = [this] { return OneOf({"==", "!=", "<", ">", "<=", ">="}); };
  if (OneIn(5)) {
    Expression first = OneIn(2) ? Atom(OneOf({"s", "t"})) : Text();
    return {"<>", {std::move(first), Atom("'" + Selection() + "'")}, {sign()}};
  }
  if (OneIn(8)) {
    const std::string text = OneOf({"'2'", "'true'", "'RED'", "'1.5'", fails_ ? "'n1'" : "'0'"});
    return {"<>", {Atom(NumberKey()), Atom(text)}, {sign()}};
  }
  Expression chain{"<>", {Amount(depth, false)}};
  const int more = OneIn(4) ? 2 : 1;
  for (int i = 0; i < more; ++i) {
    chain.of.push_back(Amount(depth, false));
    chain.signs.push_back(sign());
  }
  return chain;
}

// With one entry of a text at most: what is assigned again and again must not double.
Expression Generator::Text() {
  Expression text = OneIn(2) ? Atom(TextConstant()) : Atom(OneOf({"s", "t"}));
  if (OneIn(4)) return {"+", {std::move(text), Atom(TextConstant())}};
  const int more = OneIn(2) ? 0 : Number(1, 2);
  for (int i = 0; i < more; ++i) {
    text = {"..", {std::move(text), OneIn(2) ? Atom(TextConstant()) : Amount(1, false)}};
  }
  return text;
}

Expression Generator::AssignsNumber(const std::string& key, bool whole) {
  const std::string sign = OneOf({":=", ":=", "=", "+=", "-=", "*=", "/="});
  Expression value = Amount(sign.size() == 2 && sign != ":=" ? 1 : 2, whole);
  if (sign == "*=") value = Atom(Number(0, 2));
  if (sign == "/=") value = Atom(whole ? "1" : "2");
  return {sign, {Atom(key), std::move(value)}};
}

Expression Generator::Assigns() {
  if (OneIn(5)) {
    const std::string sign = OneOf({":=", ":=", "=", "+="});
    Expression text = OneIn(2) ? Atom("'" + Selection() + "'") : Text();
    if (sign == "+=") text = Atom(TextConstant());
    return {sign, {Atom(OneOf({"s", "t"})), std::move(text)}};
  }
  if (OneIn(12)) return {":=", {Atom("p"), Atom("'" + Place() + "'")}};
  if (OneIn(12)) return {":=", {Atom("b"), Truth(1)}};
  if (OneIn(12)) return {":=", {Atom("_p"), Amount(1, false)}};
  if (OneIn(12)) return {":=", {Atom("x"), {":=", {Atom("y"), Amount(1, true)}}}};
  if (OneIn(4)) {
    const int unit = 10;  // ms
    return OneIn(2) ? Expression{"+=", {Atom("z"), Atom(unit)}}
                    : Expression{":=", {Atom("z"), Atom(unit * Number(0, 3))}};
  }
  if (OneIn(3)) return AssignsNumber(OneOf({"d", "n", "n", "@n"}), false);
  return AssignsNumber(OneOf({"x", "x", "y", "y", "k", "@x"}), true);
}

Expression Generator::Script() {
  if (!OneIn(4)) return Assigns();
  Expression statements{";"};
  const int count = Number(2, 3);
  for (int i = 0; i < count; ++i) statements.of.push_back(Assigns());
  return statements;
}

Expression Generator::Condition() {
  if (!OneIn(12)) return Truth(2);
  Expression first = Assigns();
  return {";", {std::move(first), Truth(1)}};
}

}  // namespace musher::tree::conformance
