#pragma once
// The scripting language of BehaviorTree.CPP 4: "speed := 0.5; near = distance < 2 && !blocked".
//
//   values       1.5, 0x1F, 'text', true, false, names of enums, keys of the blackboard
//   operators    := = += -= *= /=   a ? b : c   ||   &&   == != < > <= >=   | ^   &   ..   + -
//                * /   ! ~ -        those on the right bind tighter
//   sequence     a; b; c      has the value of the last one
//
// := makes an entry, = needs one that has a value or that a port of the tree uses. A comparison may
// be a chain: 0 < x < 5. Of a text and a number the text is converted: to true or false, to the
// number of an enum, to a number. Both sides of && and || are always evaluated, as in
// BehaviorTree.CPP. Numbers are 64-bit floating-point; bit operators need whole numbers; .. joins
// texts and numbers to a text.
//
// The names become entries of the blackboard when the script is parsed. A run allocates nothing
// unless a text grows. Run() and True() throw ScriptError.

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "musher/behavior/tree/board.hpp"

namespace musher::tree {

class ScriptError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

using Enums = std::map<std::string, double, std::less<>>;

// The result of an expression. Texts and values in it belong to the script or to the blackboard. It
// has 16 bytes, so that it is passed in registers.
class Operand {
 public:
  enum class Kind : std::uint8_t { kNumber, kText, kOther };

  Operand() = default;
  explicit Operand(double number) : number_(number) {}
  explicit Operand(std::string_view text)
      : kind_(Kind::kText), size_(static_cast<std::uint32_t>(text.size())), text_(text.data()) {}
  explicit Operand(const Value& other) : kind_(Kind::kOther), other_(&other) {}

  bool is_number() const { return kind_ == Kind::kNumber; }
  bool is_text() const { return kind_ == Kind::kText; }
  // Value of its kind only.
  double number() const { return number_; }
  std::string_view text() const { return {text_, size_}; }
  const Value& other() const { return *other_; }

 private:
  Kind kind_ = Kind::kNumber;
  std::uint32_t size_ = 0;
  union {
    double number_ = 0;
    const char* text_;
    const Value* other_;
  };
};

class Script {
 public:
  // An error or a warning at a byte of the text.
  struct Finding {
    std::size_t at = 0;
    bool error = true;
    std::string what;
  };

  // Always gives a script; one with an error in `findings` must not run. With `is_condition`, an
  // assignment with '=' is warned of. `enums` must exist as long as the script.
  static Script Parse(std::string_view text, Board& board, const Enums& enums, bool is_condition,
                      std::vector<Finding>& findings);

  void Run() const;
  bool True() const;
  Operand Evaluate() const;

  // The entries that it reads and assigns.
  const std::vector<Entry*>& reads() const { return reads_; }
  const std::vector<Entry*>& writes() const { return writes_; }
  // The entries that it assigns by '=' or '+=' and has not made before by ':='.
  const std::vector<Entry*>& needs() const { return needs_; }

 private:
  friend class ScriptParser;

  enum class Code : std::uint8_t {
    kNumber,
    kText,
    kEntry,
    kNegate,
    kInvertBits,
    kNot,
    kAdd,
    kSubtract,
    kMultiply,
    kDivide,
    kJoin,
    kBitAnd,
    kBitOr,
    kBitXor,
    kAnd,
    kOr,
    kCompare,
    kIf,
    kAssign,
  };
  enum class Comparison : std::uint8_t { kEqual, kNotEqual, kLess, kGreater, kAtMost, kAtLeast };
  enum class Assignment : std::uint8_t { kMake, kSet, kAdd, kSubtract, kMultiply, kDivide };
  // `a`, `b` and `c` are operations. A chain of comparisons is linked by `c`: its next one.
  struct Operation {
    Code code = Code::kNumber;
    std::uint8_t kind = 0;  // of a comparison or an assignment
    std::uint32_t a = 0;
    std::uint32_t b = 0;
    std::uint32_t c = 0;
    double number = 0;
    Entry* entry = nullptr;
    mutable std::string text{};  // of a literal; else what the operation has made
  };

  // A script that is one comparison of entries or numbers, as most conditions are: evaluated
  // without a look at its operations, which are elsewhere in memory.
  struct Side {
    const Entry* entry = nullptr;
    double number = 0;  // without an entry

    // Null: the entry has no number.
    const double* Find() const { return entry != nullptr ? entry->value.As<double>() : &number; }
  };
  struct OneComparison {
    bool is_known = false;
    Comparison comparison = Comparison::kEqual;
    Side left;
    Side right;
  };
  void NoteOneComparison();

  Operand Evaluate(std::uint32_t at) const;
  // The same, without a call for a number.
  Operand EvaluateOperand(std::uint32_t at) const {
    const Operation& operation = operations_[at];
    if (operation.code == Code::kNumber) return Operand(operation.number);
    if (operation.code == Code::kEntry) {
      if (const double* number = operation.entry->value.As<double>()) return Operand(*number);
    }
    return Evaluate(at);
  }
  Operand Read(const Entry& entry) const;
  void Keep(const Operation& operation, Operand& operand) const;
  Operand Unary(const Operation& operation) const;
  Operand Binary(const Operation& operation) const;
  Operand Compare(const Operation& operation) const;
  template <class T>
  static bool Holds(T a, T b, Comparison comparison);
  bool CompareOther(const Operand& left, const Operand& right, Comparison comparison) const;
  Operand Join(const Operation& operation, const Operand& left, const Operand& right) const;
  // The number to which a text is converted to be compared with one.
  static std::optional<double> NumberIn(std::string_view text, const Enums& enums);
  Operand Assign(const Operation& operation) const;

  OneComparison one_;
  std::vector<Operation> operations_;
  std::vector<std::uint32_t> statements_;
  const Enums* enums_ = nullptr;
  bool assigns_inside_ = false;  // within an expression: its operands are kept
  std::vector<Entry*> reads_;
  std::vector<Entry*> writes_;
  std::vector<Entry*> needs_;
};

}  // namespace musher::tree
