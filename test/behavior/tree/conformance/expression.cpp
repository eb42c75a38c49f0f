#include "musher/test/behavior/tree/conformance/expression.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>

namespace musher::tree::conformance {
namespace {

constexpr int kPrefixRank = 11;
constexpr int kAtomRank = 12;

// The loosest first.
const std::map<std::string, int> kRanks = {{";", 0},  {":=", 1}, {"=", 1},  {"+=", 1}, {"-=", 1},
                                           {"*=", 1}, {"/=", 1}, {"?:", 2}, {"||", 3}, {"&&", 4},
                                           {"<>", 5}, {"|", 6},  {"^", 6},  {"&", 7},  {"..", 8},
                                           {"+", 9},  {"-", 9},  {"*", 10}, {"/", 10}};

int RankOf(const Expression& expression) {
  if (expression.of.empty() || expression.what == "()") return kAtomRank;
  if (expression.what == ";") return kRanks.at(";");
  return expression.of.size() == 1 ? kPrefixRank : kRanks.at(expression.what);
}

bool IsAssignment(const std::string& sign) {
  const auto rank = kRanks.find(sign);
  return rank != kRanks.end() && rank->second == kRanks.at(":=");
}

// As an operand, which needs this rank.
std::string Within(const Expression& operand, int rank) {
  const std::string text = TextOf(operand);
  return RankOf(operand) < rank ? "(" + text + ")" : text;
}

std::string ListOf(const Expression& statements) {
  std::string text;
  for (const Expression& each : statements.of) text += (text.empty() ? "" : "; ") + TextOf(each);
  return text;
}

std::string ChainOf(const Expression& chain) {
  const int rank = kRanks.at("<>") + 1;
  std::string text = Within(chain.of.front(), rank);
  for (std::size_t i = 1; i < chain.of.size(); ++i) {
    text += " " + chain.signs[i - 1] + " " + Within(chain.of[i], rank);
  }
  return text;
}

// --- evaluation ---

double NumberOf(const Datum& datum) {
  if (const auto* number = std::get_if<double>(&datum)) return *number;
  throw Broken("' needs ");
}

std::int64_t WholeOf(const Datum& datum) {
  const double number = NumberOf(datum);
  if (!std::isfinite(number) || std::floor(number) != number || std::abs(number) >= 0x1p63) {
    throw Broken("' needs ");
  }
  return static_cast<std::int64_t>(number);
}

Datum Atom(const std::string& what, const Entries& entries) {
  if (what.starts_with('\'')) return what.substr(1, what.size() - 2);
  if (what == "true") return 1.0;
  if (what == "false") return 0.0;
  if (const auto number = NumberIn(what)) return *number;
  return entries.Value(what);
}

Datum Prefix(const std::string& sign, const Datum& operand) {
  if (sign == "!") return TruthOf(operand) ? 0.0 : 1.0;
  if (sign == "-") return -NumberOf(operand);
  return static_cast<double>(~WholeOf(operand));
}

Datum Together(const std::string& sign, const Datum& left, const Datum& right) {
  const auto* const text = std::get_if<std::string>(&left);
  const auto* const more = std::get_if<std::string>(&right);
  if (sign == "..") return TextOf(left) + TextOf(right);
  if (sign == "+" && text != nullptr && more != nullptr) return *text + *more;
  if (sign == "+") return NumberOf(left) + NumberOf(right);
  if (sign == "-") return NumberOf(left) - NumberOf(right);
  if (sign == "*") return NumberOf(left) * NumberOf(right);
  if (sign == "/") return NumberOf(left) / NumberOf(right);
  if (sign == "&") return static_cast<double>(WholeOf(left) & WholeOf(right));
  if (sign == "|") return static_cast<double>(WholeOf(left) | WholeOf(right));
  if (sign == "^") return static_cast<double>(WholeOf(left) ^ WholeOf(right));
  const bool holds =
      sign == "&&" ? TruthOf(left) && TruthOf(right) : TruthOf(left) || TruthOf(right);
  return holds ? 1.0 : 0.0;
}

// Of two texts, or of two numbers: those that differ by rounding are equal.
template <class T>
bool IsTrueOf(const T& a, const std::string& sign, const T& b) {
  bool same = a == b;
  if constexpr (std::is_same_v<T, double>) {
    same = same || std::abs(a - b) <= std::numeric_limits<float>::epsilon();
  }
  if (sign == "==") return same;
  if (sign == "!=") return !same;
  if (sign == "<") return a < b;
  if (sign == ">") return a > b;
  return sign == "<=" ? a <= b : a >= b;
}

// A text beside a number: the number that it is.
double Compared(const Datum& datum) {
  if (const auto* number = std::get_if<double>(&datum)) return *number;
  const std::string& text = std::get<std::string>(datum);
  if (text == "true") return 1;
  if (text == "false") return 0;
  const auto number = NumberIn(text);
  if (!number) throw Broken("can not compare");
  return *number;
}

Datum Chain(const Expression& chain, Entries& entries) {
  Datum left = Evaluate(chain.of.front(), entries);
  for (std::size_t i = 1; i < chain.of.size(); ++i) {
    const Datum right = Evaluate(chain.of[i], entries);
    const std::string& sign = chain.signs[i - 1];
    const bool texts =
        std::holds_alternative<std::string>(left) && std::holds_alternative<std::string>(right);
    const bool holds =
        texts ? IsTrueOf(std::get<std::string>(left), sign, std::get<std::string>(right))
              : IsTrueOf(Compared(left), sign, Compared(right));
    if (!holds) return 0.0;
    left = right;
  }
  return 1.0;
}

Datum Assigned(const Expression& assignment, Entries& entries) {
  const std::string& key = assignment.of.front().what;
  const std::string& sign = assignment.what;
  if (sign != ":=" && !entries.MayAssign(key)) throw Broken("no value of");
  Datum made = Evaluate(assignment.of.back(), entries);
  if (sign != ":=" && sign != "=") made = Together(sign.substr(0, 1), entries.Value(key), made);
  entries.Set(key, made);
  return entries.Value(key);
}

}  // namespace

std::string TextOf(const Expression& expression) {
  const auto& [what, of, signs] = expression;
  if (of.empty()) return what;
  if (what == "()") return "(" + TextOf(of[0]) + ")";
  if (what == ";") return ListOf(expression);
  if (what == "<>") return ChainOf(expression);
  const int rank = RankOf(expression);
  if (of.size() == 1) return what + Within(of[0], rank + 1);
  if (what == "?:") {
    return Within(of[0], rank + 1) + " ? " + Within(of[1], rank) + " : " + Within(of[2], rank);
  }
  const bool to_the_right = IsAssignment(what);
  return Within(of[0], to_the_right ? rank + 1 : rank) + " " + what + " " +
         Within(of[1], to_the_right ? rank : rank + 1);
}

std::string TextOf(const Datum& datum) {
  if (const auto* text = std::get_if<std::string>(&datum)) return *text;
  const double number = std::get<double>(datum);
  if (std::floor(number) == number && std::abs(number) < 0x1p63) {
    return std::to_string(static_cast<std::int64_t>(number));
  }
  std::array<char, 40> room{};
  return {room.data(), std::to_chars(room.data(), room.data() + room.size(), number).ptr};
}

std::optional<double> NumberIn(const std::string& text) {
  if (const auto known = kEnums.find(text); known != kEnums.end()) return known->second;
  if (text.empty() || text.front() == ' ') return std::nullopt;
  char* end = nullptr;
  const double number = std::strtod(text.c_str(), &end);
  return *end == '\0' ? std::optional(number) : std::nullopt;
}

bool TruthOf(const Datum& datum) {
  if (const auto* number = std::get_if<double>(&datum)) return *number != 0;
  const std::string& text = std::get<std::string>(datum);
  if (text == "true" || text == "1") return true;
  if (text == "false" || text == "0") return false;
  throw Broken("expected true or false");
}

Datum Evaluate(const Expression& expression, Entries& entries) {
  const auto& [what, of, signs] = expression;
  if (of.empty()) return Atom(what, entries);
  if (what == "()") return Evaluate(of[0], entries);
  if (what == "<>") return Chain(expression, entries);
  if (what == ";") {
    Datum last;
    for (const Expression& each : of) last = Evaluate(each, entries);
    return last;
  }
  if (IsAssignment(what)) return Assigned(expression, entries);
  const Datum first = Evaluate(of[0], entries);
  if (of.size() == 1) return Prefix(what, first);
  if (what == "?:") return Evaluate(of[TruthOf(first) ? 1 : 2], entries);
  const Datum second = Evaluate(of[1], entries);
  return Together(what, first, second);
}

}  // namespace musher::tree::conformance
