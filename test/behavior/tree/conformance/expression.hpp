#pragma once
// Scripts of trees for tests: trees of operators, which are written with no more parentheses than
// the ranks of the documentation need, and evaluated as it says (docs/behavior-trees.md, that of
// BehaviorTree.CPP).

#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

namespace musher::tree::conformance {

// Thrown by a node: why it fails.
class Broken : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct Expression {
  std::string what;                  // "2", "'n1'", "x", "RED"; an operator: "+", "()", ":=", ";"
  std::vector<Expression> of{};      // its operands: two of "-" subtract, one is a sign
  std::vector<std::string> signs{};  // of "<>", a chain of comparisons: "<", "==", ...
};
std::string TextOf(const Expression& expression);

using Datum = std::variant<double, std::string>;
std::string TextOf(const Datum& datum);

inline const std::map<std::string, double> kEnums = {{"BLUE", 3}, {"GREEN", 2}, {"RED", 1}};
// "2", "1.5", "RED"
std::optional<double> NumberIn(const std::string& text);
// Of a condition. Throws Broken.
bool TruthOf(const Datum& datum);

// What scripts read and assign. Each may throw Broken.
class Entries {
 public:
  virtual ~Entries() = default;
  virtual Datum Value(const std::string& key) const = 0;
  virtual void Set(const std::string& key, const Datum& datum) = 0;
  // By other operators than ":=".
  virtual bool MayAssign(const std::string& key) const = 0;
};

// The value of the last statement.
Datum Evaluate(const Expression& expression, Entries& entries);

}  // namespace musher::tree::conformance
