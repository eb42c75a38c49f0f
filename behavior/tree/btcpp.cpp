#include "musher/behavior/tree/btcpp.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "musher/behavior/tree/conditions.hpp"

namespace musher::tree {
namespace {

constexpr const char* kThere = "BehaviorTree.CPP 4.10 ";

bool IsOneOf(std::string_view name, std::initializer_list<std::string_view> names) {
  return std::ranges::find(names, name) != names.end();
}

bool IsFormOfNode(std::string_view name) {
  return IsOneOf(name, {"Action", "Condition", "Decorator", "Control"});
}

// The class of a node: of <Move/> or <Action ID="Move"/>.
std::string_view ClassIn(const Element& element) {
  const Attribute* id = IsFormOfNode(element.name) ? element.Find("ID") : nullptr;
  return id == nullptr ? std::string_view(element.name) : std::string_view(id->value);
}

bool MayBeSkipped(const Element& element) {
  return element.Find("_skipIf") != nullptr || element.Find("_while") != nullptr;
}

// The script without its texts: '…' becomes spaces.
std::string WithoutTexts(std::string_view script) {
  std::string code;
  bool in_text = false;
  for (const char c : script) {
    const bool quote = c == '\'';
    code += in_text || quote ? ' ' : c;
    if (quote) in_text = !in_text;
  }
  return code;
}

bool IsSpace(char c) {
  return std::isspace(static_cast<unsigned char>(c)) != 0;
}

// Whether the '-' at `at` stands before its operand: "-1", "2 * -x", or in "1e-3".
bool IsSign(std::string_view code, std::size_t at) {
  const auto is_digit = [&code](std::size_t i) {
    return std::isdigit(static_cast<unsigned char>(code[i])) != 0 || code[i] == '.';
  };
  const bool exponent = at >= 2 && (code[at - 1] == 'e' || code[at - 1] == 'E') && is_digit(at - 2);
  if (exponent) return true;
  while (at > 0 && IsSpace(code[at - 1])) --at;
  return at == 0 || std::string_view("=<>!&|^+-*/?:,").find(code[at - 1]) != std::string::npos ||
         code.substr(0, at).ends_with("..");
}

// `code` is a statement without texts and parentheses.
bool MixesRanks(std::string code) {
  for (std::size_t at = code.find('-'); at != std::string::npos; at = code.find('-', at + 1)) {
    if (IsSign(code, at)) code[at] = ' ';
  }
  const auto erase = [&code](std::string_view what) {
    std::size_t count = 0;
    for (auto at = code.find(what); at != std::string::npos; at = code.find(what)) {
      code.replace(at, what.size(), " ");
      ++count;
    }
    return count;
  };
  for (const std::string_view assignment : {":=", "+=", "-=", "*=", "/="}) erase(assignment);
  const std::size_t usual = erase("&&") + erase("||") + erase("==") + erase("!=") + erase("<=") +
                            erase(">=") + erase("<") + erase(">") + erase("+") + erase("*") +
                            erase("/") + erase("-") + erase("?");
  const std::array<std::size_t, 4> special = {erase(".."), erase("&"), erase("|"), erase("^")};
  const auto kinds = std::ranges::count_if(special, [](std::size_t count) { return count > 0; });
  return kinds > 1 || (kinds == 1 && usual > 0);
}

// Operators whose rank BehaviorTree.CPP does not document, beside others, where no parentheses say
// it.
bool HasUndocumentedRank(std::string_view script) {
  std::string code = WithoutTexts(script);
  for (auto end = code.find(')'); end != std::string::npos; end = code.find(')')) {
    const auto open = code.rfind('(', end);
    const std::size_t begin = open == std::string::npos ? 0 : open + 1;
    if (MixesRanks(code.substr(begin, end - begin))) return true;
    code.replace(begin > 0 ? begin - 1 : 0, end + 1 - (begin > 0 ? begin - 1 : 0), "x");
  }
  for (std::size_t begin = 0; begin < code.size();) {
    const std::size_t end = std::min(code.find(';', begin), code.size());
    if (MixesRanks(code.substr(begin, end - begin))) return true;
    begin = end + 1;
  }
  return false;
}

enum class Literal : std::uint8_t { kNone, kWhole, kFraction, kText };

struct Assigned {
  std::string key;
  Literal literal = Literal::kNone;
  std::size_t at = 0;  // of the key in the script
};

std::string_view Bare(std::string_view text) {
  while (!text.empty() && IsSpace(text.front())) text.remove_prefix(1);
  while (!text.empty() && IsSpace(text.back())) text.remove_suffix(1);
  return text;
}

Literal LiteralOf(std::string_view text) {
  if (text.size() >= 2 && text.front() == '\'' && text.find('\'', 1) == text.size() - 1) {
    return Literal::kText;
  }
  if (text == "true" || text == "false") return Literal::kWhole;
  const Result<double> number = Convert<double>::FromText(text);
  if (!number) return Literal::kNone;
  return Fits<std::int64_t>(number.value()) ? Literal::kWhole : Literal::kFraction;
}

// Statements that assign a literal: "n := 2.7".
std::vector<Assigned> AssignedIn(std::string_view script) {
  std::vector<Assigned> found;
  const std::string code = WithoutTexts(script);
  for (std::size_t begin = 0; begin < script.size();) {
    const std::size_t end = std::min(code.find(';', begin), script.size());
    const std::string_view statement = script.substr(begin, end - begin);
    const std::size_t sign = code.substr(begin, end - begin).find('=');
    if (sign != std::string::npos && sign > 0) {
      std::string_view key = statement.substr(0, sign);
      if (key.ends_with(':')) key.remove_suffix(1);
      key = Bare(key);
      const bool is_key = std::ranges::all_of(
          key, [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; });
      const Literal literal = LiteralOf(Bare(statement.substr(sign + 1)));
      if (!key.empty() && is_key && literal != Literal::kNone) {
        found.push_back(
            {std::string(key), literal, static_cast<std::size_t>(key.data() - script.data())});
      }
    }
    begin = end + 1;
  }
  return found;
}

bool IsText(const Type* type) {
  return type == TypeOf<std::string>();
}

bool IsWholeType(const Type* type) {
  return type == TypeOf<int>() || type == TypeOf<unsigned>() || type == TypeOf<std::int64_t>() ||
         type == TypeOf<std::uint64_t>();
}

class Differences {
 public:
  Differences(const Document& document, const Factory& factory)
      : document_(document), factory_(factory) {}

  std::vector<Diagnostic> Find() && {
    for (const Document::Tree& tree : document_.trees) {
      names_.clear();
      keys_.clear();
      LookAtTree(tree);
      Look(tree.content);
      LookAtKeys();
    }
    std::ranges::sort(found_);
    found_.erase(std::unique(found_.begin(), found_.end()), found_.end());
    std::vector<Diagnostic> diagnostics;
    for (auto& [place, what] : found_) {
      diagnostics.push_back(document_.At(place, Severity::kWarning, std::move(what)));
    }
    return diagnostics;
  }

 private:
  struct Key {
    struct Port {
      std::string name;
      const Type* type = nullptr;
      Place place;
    };
    std::vector<Port> texts{};   // inputs that read it as a text
    std::vector<Port> others{};  // ports of another type
    std::vector<std::pair<Literal, Place>> assigned{};
  };

  void Add(Place place, const std::string& there, const std::string& here) {
    found_.emplace_back(place, kThere + there + "; here " + here);
  }

  void LookAtTree(const Document::Tree& tree) {
    const Attribute* id = tree.content.Find("ID");
    if (id == nullptr) return;
    if (factory_.Find(tree.id) != nullptr) {
      Add(id->value_at, "refuses a tree with the name of a node",
          "only <SubTree ID=\"" + tree.id + "\"/> means the tree");
    }
    LookAtName(*id, "a tree");
  }

  void LookAtName(const Attribute& id, const std::string& of) {
    if (id.value.find('.') != std::string::npos) AddName(id.value_at, of);
  }
  void AddName(Place place, const std::string& of) {
    Add(place, "refuses '.' in the name of " + of, "it is allowed");
  }

  void Look(const Element& parent) {
    for (const Element& element : parent.children) {
      const std::string_view name = ClassIn(element);
      if (IsOneOf(name, {"SubTree", "SubTreePlus"})) {
        LookAtSubtree(element);
      } else {
        if (IsFormOfNode(element.name)) {
          if (const Attribute* id = element.Find("ID")) LookAtName(*id, "a node");
        } else if (element.name.find('.') != std::string::npos) {
          AddName(element.at, "a node");
        }
        LookAtNode(element, name);
        LookAtPorts(element, name);
      }
      LookAtAttributes(element);
      Look(element);
    }
  }

  void LookAtSubtree(const Element& element) {
    if (element.name == "SubTreePlus") {
      Add(element.at, "knows <SubTreePlus> only where it was compiled for version 3",
          "it is a <SubTree> with _autoremap=\"true\"");
    }
    const Attribute* name = element.Find("name");
    if (name == nullptr || names_.insert(name->value).second) return;
    Add(name->value_at, "refuses a second subtree of this name in the tree",
        "its path ends with #2");
  }

  // Whether it or a node in it may return RUNNING; not in its subtrees.
  bool MayRun(const Element& element) const {
    const Factory::Registered* registered = factory_.Find(ClassIn(element));
    if (registered != nullptr && registered->takes_time) return true;
    return std::ranges::any_of(element.children,
                               [this](const Element& child) { return MayRun(child); });
  }

  void LookAtNode(const Element& element, std::string_view name) {
    if (name == "WhileDoElse" && !element.children.empty() && MayRun(element.children.front())) {
      Add(element.children.front().at,
          "leaves the branch running without ticks while this condition is RUNNING",
          "it is halted");
    }
    if (IsOneOf(name, {"IfThenElse", "WhileDoElse"}) && !element.children.empty() &&
        MayBeSkipped(element.children.front())) {
      Add(element.children.front().at, "throws where this condition is skipped",
          std::string(name) + " is skipped");
    }
    if (IsOneOf(name, {"Delay", "Timeout"}) && !element.children.empty() &&
        MayBeSkipped(element.children.front())) {
      Add(element.children.front().at,
          "keeps the decorator RUNNING where this child is skipped, and its time goes on",
          "the time begins again");
    }
    if (name == "Parallel" && !element.children.empty() &&
        std::ranges::all_of(element.children, MayBeSkipped)) {
      Add(element.at, "has a result by success_count where all children are skipped",
          "it is skipped");
    }
    if (IsOneOf(name, {"SkipUnlessUpdated", "WaitValueUpdate"})) {
      Add(element.at, "does not halt the child of this node with it", "it is halted");
    }
    if (name == "Finally") {
      Add(element.at, "waits for the second child, with sleeps, in a halt",
          "it is ticked once: a halt takes no time");
    }
    const Attribute* on_halt = element.Find("catch_on_halt");
    const bool catches = name == "TryCatch" && on_halt != nullptr && on_halt->value != "false";
    if (name == "Finally" || catches) {
      Add(element.at, "prints what the clean-up throws in a halt", "that is an error of the tick");
    }
    if (name == "ManualSelector") {
      Add(element.at, "asks on the terminal of the process, which waits",
          "the entry of 'selection' has the answer");
    }
    LookAtLimits(element, name);
    LookAtReactive(element, name);
  }

  void LookAtLimits(const Element& element, std::string_view name) {
    if (IsOneOf(name, {"Repeat", "RetryUntilSuccessful"})) {
      const Attribute* times = element.Find(name == "Repeat" ? "num_cycles" : "num_attempts");
      if (times != nullptr && times->value == "-1") {
        Add(times->value_at, "ticks for ever in tickOnce while the child ends at once",
            "TickOnce ticks at most 100 times");
      }
      const bool is_entry = times != nullptr && KeyOf(times->value, times->name);
      if (is_entry && !element.children.empty() && MayRun(element.children.front())) {
        Add(times->value_at, "leaves the child running where this number becomes smaller meanwhile",
            "it is halted");
      }
    }
    if (!name.starts_with("Switch") || name.size() != 7) return;
    for (const Attribute& attribute : element.attributes) {
      if (!attribute.name.starts_with("case_")) continue;
      if (LiteralOf(attribute.value) != Literal::kFraction) continue;
      Add(attribute.value_at, "takes numbers that differ by less than 1e-7 for equal",
          "only equal numbers are");
    }
  }

  // Children that run at the same time are halted in both, but one kind is refused there.
  void LookAtReactive(const Element& element, std::string_view name) {
    if (name != "ReactiveSequence") return;
    bool is_first = true;
    for (const Element& child : element.children) {
      if (child.name != "AsyncSequence" || std::exchange(is_first, false)) continue;
      Add(child.at, "refuses a second AsyncSequence in a ReactiveSequence",
          "it is allowed, with a warning");
    }
  }

  void LookAtAttributes(const Element& element) {
    for (const Attribute& attribute : element.attributes) {
      if (attribute.name.find('.') != std::string::npos) AddName(attribute.at, "a port");
      const bool is_condition =
          std::ranges::find(kConditionNames, attribute.name) != kConditionNames.end();
      const std::string_view node = ClassIn(element);
      const bool is_script =
          is_condition ||
          (attribute.name == "code" && IsOneOf(node, {"Script", "ScriptCondition"})) ||
          (attribute.name == "if" && node == "Precondition");
      if (is_script) LookAtScript(attribute);
    }
  }

  void LookAtScript(const Attribute& script) {
    if (HasUndocumentedRank(script.value)) {
      Add(script.value_at, "does not document the rank of '..' and of bit operators",
          "it is that of the table of operators: use parentheses");
    }
    for (const Assigned& each : AssignedIn(script.value)) {
      keys_[each.key].assigned.emplace_back(each.literal, document_.Inside(script, each.at));
    }
  }

  const std::vector<PortModel>& PortsOf(std::string_view node) {
    const auto known = ports_.find(node);
    if (known != ports_.end()) return known->second;
    return ports_.emplace(std::string(node), factory_.PortsOf(node)).first->second;
  }

  void LookAtPorts(const Element& element, std::string_view name) {
    for (const PortModel& port : PortsOf(name)) {
      const Attribute* attribute = element.Find(port.name);
      if (attribute == nullptr || port.direction == Direction::kText) continue;
      const auto key = KeyOf(attribute->value, port.name);
      if (!key) {
        if (port.direction == Direction::kInOut) {
          Add(attribute->value_at, "fails where a node writes to this port, which is a fixed text",
              "what is written is lost");
        }
        continue;
      }
      if (port.type == nullptr) continue;
      Key& used = keys_[std::string(*key)];
      const bool reads_text = IsText(port.type) && port.direction == Direction::kIn;
      (reads_text ? used.texts : used.others)
          .push_back({port.name, port.type, attribute->value_at});
    }
  }

  // The keys of one tree.
  void LookAtKeys() {
    for (const auto& [name, key] : keys_) {
      const auto other = std::ranges::find_if(
          key.others, [](const Key::Port& port) { return !IsText(port.type); });
      const bool has_other = other != key.others.end();
      for (const Key::Port& port : key.texts) {
        if (!has_other) continue;
        Add(port.place,
            "refuses a port of type text on '" + name + "', which is of type " +
                std::string(other->type->name),
            "it is read as a text");
      }
      LookAtLiterals(name, key, has_other ? other->type : nullptr);
    }
  }

  void LookAtLiterals(const std::string& name, const Key& key, const Type* type) {
    const bool has_port = !key.others.empty() || !key.texts.empty();
    for (const auto& [literal, place] : key.assigned) {
      if (IsWholeType(type) && literal == Literal::kFraction) {
        Add(place, "may lose the fraction",
            "the tick ends with an error: '" + name + "' is a whole number");
      }
      const bool is_text = literal == Literal::kText;
      const bool first_is_text = key.assigned.front().first == Literal::kText;
      if (has_port || is_text == first_is_text) continue;
      Add(place, "keeps the type of the first value of '" + name + "'",
          "it takes the type of this one");
    }
  }

  const Document& document_;
  const Factory& factory_;
  std::vector<std::pair<Place, std::string>> found_;
  std::map<std::string, std::vector<PortModel>, std::less<>> ports_;
  std::set<std::string> names_;      // of subtrees, in the present tree
  std::map<std::string, Key> keys_;  // of the present tree
};

}  // namespace

std::vector<Diagnostic> DifferencesToBtcpp(const Document& document, const Factory& factory) {
  return Differences(document, factory).Find();
}

}  // namespace musher::tree
