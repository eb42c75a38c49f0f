#include "musher/behavior/tree/script.hpp"

#include <cmath>
#include <limits>

namespace musher::tree {
namespace {

std::string Shown(const Operand& operand) {
  if (operand.is_number()) return NumberText(operand.number());
  if (operand.is_text()) return "'" + std::string(operand.text()) + "'";
  return operand.other().Shown();
}

[[noreturn]] void FailNumber(const Operand& operand, std::string_view sign) {
  throw ScriptError("'" + std::string(sign) + "' needs numbers; got " + Shown(operand));
}

double NumberOf(const Operand& operand, std::string_view sign) {
  if (!operand.is_number()) FailNumber(operand, sign);
  return operand.number();
}

std::int64_t WholeOf(const Operand& operand, std::string_view sign) {
  const double number = NumberOf(operand, sign);
  if (std::trunc(number) != number || std::abs(number) >= std::ldexp(1.0, 63)) {
    throw ScriptError("'" + std::string(sign) + "' needs whole numbers; got " + Shown(operand));
  }
  return static_cast<std::int64_t>(number);
}

bool TruthOfOther(const Operand& operand) {
  if (operand.is_text()) {
    if (const auto truth = Convert<bool>::FromText(operand.text())) return truth.value();
  }
  throw ScriptError("expected true or false, or a number; got " + Shown(operand));
}

bool TruthOf(const Operand& operand) {
  return operand.is_number() ? operand.number() != 0 : TruthOfOther(operand);
}

// Numbers that a 32-bit floating-point number can not tell apart from 1 are equal, as in
// BehaviorTree.CPP.
bool Same(double a, double b) {
  return a == b || std::abs(a - b) <= static_cast<double>(std::numeric_limits<float>::epsilon());
}
bool Same(std::string_view a, std::string_view b) {
  return a == b;
}

}  // namespace

template <class T>
bool Script::Holds(T a, T b, Comparison comparison) {
  switch (comparison) {
    case Comparison::kEqual:
      return Same(a, b);
    case Comparison::kNotEqual:
      return !Same(a, b);
    case Comparison::kLess:
      return a < b;
    case Comparison::kGreater:
      return a > b;
    case Comparison::kAtMost:
      return a <= b;
    case Comparison::kAtLeast:
      return a >= b;
  }
  return false;
}

Operand Script::Evaluate() const {
  Operand last;
  for (const std::uint32_t statement : statements_) last = EvaluateOperand(statement);
  return last;
}

void Script::Run() const {
  Evaluate();
}

bool Script::True() const {
  if (one_.is_known) {
    const double* left = one_.left.Find();
    const double* right = one_.right.Find();
    if (left != nullptr && right != nullptr) return Holds(*left, *right, one_.comparison);
  }
  return TruthOf(Evaluate());
}

void Script::NoteOneComparison() {
  if (statements_.size() != 1) return;
  const Operation& only = operations_[statements_.front()];
  if (only.code != Code::kCompare || only.c != 0) return;
  const auto side_of = [](const Operation& operand) { return Side{operand.entry, operand.number}; };
  const auto is_side = [](const Operation& operand) {
    return operand.code == Code::kNumber || operand.code == Code::kEntry;
  };
  const Operation& left = operations_[only.a];
  const Operation& right = operations_[only.b];
  if (!is_side(left) || !is_side(right)) return;
  one_ = {true, static_cast<Comparison>(only.kind), side_of(left), side_of(right)};
}

Operand Script::Evaluate(std::uint32_t at) const {
  const Operation& operation = operations_[at];
  switch (operation.code) {
    case Code::kNumber:
      return Operand(operation.number);
    case Code::kText:
      return Operand(std::string_view(operation.text));
    case Code::kEntry:
      return Read(*operation.entry);
    case Code::kNegate:
    case Code::kInvertBits:
    case Code::kNot:
      return Unary(operation);
    case Code::kCompare:
      return Compare(operation);
    case Code::kIf: {
      const Operand condition = EvaluateOperand(operation.a);
      const bool is_text = condition.is_text();
      const bool holds = is_text ? !condition.text().empty() : TruthOf(condition);
      return Evaluate(holds ? operation.b : operation.c);
    }
    case Code::kAssign:
      return Assign(operation);
    default:
      return Binary(operation);
  }
}

Operand Script::Read(const Entry& entry) const {
  const Value& value = entry.value;
  if (const double* number = value.As<double>()) return Operand(*number);
  if (const std::string* text = value.Text()) return Operand(std::string_view(*text));
  double number = 0;
  if (value.ToNumber(number)) return Operand(number);
  if (value.empty()) {
    throw ScriptError("the blackboard has no value of '" + entry.key + "'");
  }
  return Operand(value);
}

// An assignment in the other operand may change the text that an operand refers to.
void Script::Keep(const Operation& operation, Operand& operand) const {
  if (!assigns_inside_ || !operand.is_text()) return;
  operation.text.assign(operand.text());
  operand = Operand(std::string_view(operation.text));
}

Operand Script::Unary(const Operation& operation) const {
  const Operand operand = EvaluateOperand(operation.a);
  if (operation.code == Code::kNegate) return Operand(-NumberOf(operand, "-"));
  if (operation.code == Code::kNot) return Operand(TruthOf(operand) ? 0.0 : 1.0);
  return Operand(static_cast<double>(~WholeOf(operand, "~")));
}

Operand Script::Binary(const Operation& operation) const {
  Operand left = EvaluateOperand(operation.a);
  Keep(operation, left);
  const Operand right = EvaluateOperand(operation.b);
  switch (operation.code) {
    case Code::kAdd:
      if (left.is_text() && right.is_text()) {
        operation.text.assign(left.text());
        operation.text.append(right.text());
        return Operand(std::string_view(operation.text));
      }
      return Operand(NumberOf(left, "+") + NumberOf(right, "+"));
    case Code::kSubtract:
      return Operand(NumberOf(left, "-") - NumberOf(right, "-"));
    case Code::kMultiply:
      return Operand(NumberOf(left, "*") * NumberOf(right, "*"));
    case Code::kDivide:
      return Operand(NumberOf(left, "/") / NumberOf(right, "/"));
    case Code::kJoin:
      return Join(operation, left, right);
    case Code::kBitAnd:
      return Operand(static_cast<double>(WholeOf(left, "&") & WholeOf(right, "&")));
    case Code::kBitOr:
      return Operand(static_cast<double>(WholeOf(left, "|") | WholeOf(right, "|")));
    case Code::kBitXor:
      return Operand(static_cast<double>(WholeOf(left, "^") ^ WholeOf(right, "^")));
    case Code::kAnd:
      return Operand(TruthOf(left) && TruthOf(right) ? 1.0 : 0.0);
    default:
      return Operand(TruthOf(left) || TruthOf(right) ? 1.0 : 0.0);
  }
}

Operand Script::Join(const Operation& operation, const Operand& left, const Operand& right) const {
  std::string joined;
  for (const Operand& each : {left, right}) {
    if (!each.is_number() && !each.is_text()) {
      throw ScriptError("'..' needs texts or numbers; got " + Shown(each));
    }
    joined += each.is_text() ? std::string(each.text()) : NumberText(each.number());
  }
  operation.text = std::move(joined);
  return Operand(std::string_view(operation.text));
}

std::optional<double> Script::NumberIn(std::string_view text, const Enums& enums) {
  if (text == "true") return 1;
  if (text == "false") return 0;
  if (const auto known = enums.find(text); known != enums.end()) return known->second;
  const auto number = Convert<double>::FromText(text);
  return number ? std::optional(number.value()) : std::nullopt;
}

// Compares operands that are not both numbers.
bool Script::CompareOther(const Operand& left, const Operand& right, Comparison comparison) const {
  if (left.is_text() && right.is_text()) return Holds(left.text(), right.text(), comparison);
  const auto number = [&](const Operand& operand) {
    if (operand.is_number()) return operand.number();
    const auto in = operand.is_text() ? NumberIn(operand.text(), *enums_) : std::nullopt;
    if (!in) throw ScriptError("can not compare " + Shown(left) + " with " + Shown(right));
    return *in;
  };
  return Holds(number(left), number(right), comparison);
}

Operand Script::Compare(const Operation& first) const {
  Operand left = EvaluateOperand(first.a);
  const Operation* operation = &first;
  while (true) {
    Keep(*operation, left);
    const Operand right = EvaluateOperand(operation->b);
    const auto comparison = static_cast<Comparison>(operation->kind);
    const bool holds = left.is_number() && right.is_number()
                           ? Holds(left.number(), right.number(), comparison)
                           : CompareOther(left, right, comparison);
    if (!holds) return Operand(0.0);
    if (operation->c == 0) return Operand(1.0);
    operation = &operations_[operation->c];
    left = right;
  }
}

Operand Script::Assign(const Operation& operation) const {
  Entry& entry = *operations_[operation.a].entry;
  const auto kind = static_cast<Assignment>(operation.kind);
  if (kind != Assignment::kMake && entry.value.empty() && !entry.declared) {
    throw ScriptError("the blackboard has no value of '" + entry.key +
                      "'; to make an entry, use ':='");
  }
  Operand right = EvaluateOperand(operation.b);
  if (kind != Assignment::kMake && kind != Assignment::kSet) {
    const Operand left = Read(entry);
    if (kind == Assignment::kAdd && left.is_text() && right.is_text()) {
      operation.text.assign(left.text());
      operation.text.append(right.text());
      right = Operand(std::string_view(operation.text));
    } else if (kind == Assignment::kAdd) {
      right = Operand(NumberOf(left, "+=") + NumberOf(right, "+="));
    } else if (kind == Assignment::kSubtract) {
      right = Operand(NumberOf(left, "-=") - NumberOf(right, "-="));
    } else if (kind == Assignment::kMultiply) {
      right = Operand(NumberOf(left, "*=") * NumberOf(right, "*="));
    } else {
      right = Operand(NumberOf(left, "/=") / NumberOf(right, "/="));
    }
  }
  Result<> assigned;
  if (right.is_number()) {
    assigned = entry.AssignNumber(right.number());
  } else if (right.is_text()) {
    assigned = entry.AssignText(right.text());
  } else {
    assigned = entry.Assign(right.other());
  }
  if (!assigned) throw ScriptError("'" + entry.key + "': " + assigned.error().message);
  return Read(entry);
}

}  // namespace musher::tree
