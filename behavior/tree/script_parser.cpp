#include <algorithm>
#include <cctype>
#include <optional>

#include "musher/behavior/tree/script.hpp"

namespace musher::tree {

// A parser by recursive descent, one function for each rank of operators.
class ScriptParser {
 public:
  ScriptParser(std::string_view text, Board& board, const Enums& enums, bool is_condition,
               std::vector<Script::Finding>& findings)
      : text_(text), board_(board), enums_(enums), is_condition_(is_condition), found_(findings) {
    script_.enums_ = &enums;
  }

  Script Parse() && {
    Skip();
    while (!failed_ && at_ < text_.size()) {
      if (Take(";")) continue;
      const Index statement = AssignmentLevel();
      if (failed_) break;
      script_.statements_.push_back(statement);
      if (at_ < text_.size() && !Take(";")) Fail("expected an operator or ';'");
    }
    if (!failed_ && script_.statements_.empty()) Fail("the script is empty");
    if (!failed_) script_.NoteOneComparison();
    return std::move(script_);
  }

 private:
  using Index = std::uint32_t;
  using Code = Script::Code;
  // Parentheses, prefixes and branches in each other, which the parser follows by calls.
  static constexpr int kDeepest = 100;
  // Operators in each other, which the evaluation follows by calls: 1 + 2 + 3 are two.
  static constexpr std::uint32_t kDeepestOperation = 1000;

  Index AssignmentLevel() {
    const DepthGuard nesting(*this);
    const Index left = ConditionalLevel();
    using Assignment = Script::Assignment;
    static constexpr std::pair<std::string_view, Assignment> kOperators[] = {
        {":=", Assignment::kMake},     {"+=", Assignment::kAdd},    {"-=", Assignment::kSubtract},
        {"*=", Assignment::kMultiply}, {"/=", Assignment::kDivide}, {"=", Assignment::kSet}};
    for (const auto& [sign, kind] : kOperators) {
      if (failed_ || !text_.substr(at_).starts_with(sign)) continue;
      if (sign == "=" && text_.substr(at_).starts_with("==")) continue;
      if (At(left).code != Code::kEntry) {
        Fail("only an entry of the blackboard can be assigned to");
        return 0;
      }
      if (kind == Assignment::kSet && is_condition_) {
        Warn("'=' assigns; to compare, use '=='");
      }
      Take(sign);
      Entry* entry = At(left).entry;
      if (kind == Assignment::kMake || kind == Assignment::kSet) Unread(entry);
      if (kind != Assignment::kMake &&
          std::ranges::find(script_.writes_, entry) == script_.writes_.end()) {
        script_.needs_.push_back(entry);
      }
      script_.writes_.push_back(entry);
      if (depth_ > 1) script_.assigns_inside_ = true;
      const Index right = AssignmentLevel();
      const Index made = Add(Code::kAssign, left, right);
      At(made).kind = static_cast<std::uint8_t>(kind);
      return made;
    }
    return left;
  }

  Index ConditionalLevel() {
    const Index condition = OrLevel();
    if (failed_ || !Take("?")) return condition;
    const Index yes = AssignmentLevel();
    if (!failed_ && (text_.substr(at_).starts_with(":=") || !Take(":"))) {
      Fail("expected ':' of 'condition ? value : value'");
    }
    const DepthGuard nesting(*this);
    const Index no = failed_ ? 0 : ConditionalLevel();
    const Index made = Add(Code::kIf, condition, yes);
    At(made).c = no;
    Deepen(made, no);
    return made;
  }

  Index OrLevel() {
    Index left = AndLevel();
    while (!failed_ && Take("||")) {
      const Index right = AndLevel();
      left = Add(Code::kOr, left, right);
    }
    return left;
  }
  Index AndLevel() {
    Index left = ComparisonLevel();
    while (!failed_ && Take("&&")) {
      const Index right = ComparisonLevel();
      left = Add(Code::kAnd, left, right);
    }
    return left;
  }

  Index ComparisonLevel() {
    using Comparison = Script::Comparison;
    static constexpr std::pair<std::string_view, Comparison> kOperators[] = {
        {"==", Comparison::kEqual},   {"!=", Comparison::kNotEqual}, {"<=", Comparison::kAtMost},
        {">=", Comparison::kAtLeast}, {"<", Comparison::kLess},      {">", Comparison::kGreater}};
    const Index first = BitOrLevel();
    Index left = first;
    std::optional<Index> head;
    Index tail = 0;
    while (!failed_) {
      const auto* found =
          std::ranges::find_if(kOperators, [this](const auto& one) { return Take(one.first); });
      if (found == std::end(kOperators)) break;
      const std::size_t at = at_;
      const Index right = BitOrLevel();
      CheckComparison(left, right, at);
      const Index made = Add(Code::kCompare, left, right);
      At(made).kind = static_cast<std::uint8_t>(found->second);
      if (head) {
        At(tail).c = made;
        Deepen(*head, right);
      } else {
        head = made;
      }
      tail = made;
      left = right;
    }
    return head.value_or(first);
  }

  // A text that is no number can not be compared with one, whatever the tree does.
  void CheckComparison(Index left, Index right, std::size_t at) {
    if (failed_) return;
    const bool text_first = At(left).code == Code::kText;
    const Script::Operation& text = At(text_first ? left : right);
    const Script::Operation& number = At(text_first ? right : left);
    if (text.code != Code::kText || number.code != Code::kNumber) return;
    if (Script::NumberIn(text.text, enums_)) return;
    found_.push_back({at, true,
                      "'" + text.text + "' can not be compared with " + NumberText(number.number) +
                          ": it is neither a number nor the name of an enum"});
  }

  Index BitOrLevel() {
    Index left = BitAndLevel();
    while (!failed_) {
      const bool is_or = Peek() == '|' && Peek(1) != '|';
      if (!is_or && Peek() != '^') break;
      Take(is_or ? "|" : "^");
      const Index right = BitAndLevel();
      left = Add(is_or ? Code::kBitOr : Code::kBitXor, left, right);
    }
    return left;
  }
  Index BitAndLevel() {
    Index left = JoinLevel();
    while (!failed_ && Peek() == '&' && Peek(1) != '&') {
      Take("&");
      const Index right = JoinLevel();
      left = Add(Code::kBitAnd, left, right);
    }
    return left;
  }
  Index JoinLevel() {
    Index left = SumLevel();
    while (!failed_ && Take("..")) {
      const Index right = SumLevel();
      left = Add(Code::kJoin, left, right);
    }
    return left;
  }
  Index SumLevel() {
    Index left = ProductLevel();
    while (!failed_ && (Peek() == '+' || Peek() == '-') && Peek(1) != '=') {
      const Code code = Peek() == '+' ? Code::kAdd : Code::kSubtract;
      Advance(1);
      const Index right = ProductLevel();
      left = Add(code, left, right);
    }
    return left;
  }
  Index ProductLevel() {
    Index left = PrefixLevel();
    while (!failed_ && (Peek() == '*' || Peek() == '/') && Peek(1) != '=') {
      const Code code = Peek() == '*' ? Code::kMultiply : Code::kDivide;
      Advance(1);
      const Index right = PrefixLevel();
      left = Add(code, left, right);
    }
    return left;
  }
  Index PrefixLevel() {
    const DepthGuard nesting(*this);
    if (failed_) return 0;
    if (Take("-")) return AddPrefix(Code::kNegate);
    if (Take("~")) return AddPrefix(Code::kInvertBits);
    if (Peek() == '!' && Peek(1) != '=' && Take("!")) return AddPrefix(Code::kNot);
    return Atom();
  }
  Index AddPrefix(Code code) {
    const Index operand = PrefixLevel();
    return Add(code, operand, 0);
  }

  Index Atom() {
    if (Take("(")) {
      const Index inside = AssignmentLevel();
      if (!failed_ && !Take(")")) Fail("expected ')'");
      return inside;
    }
    const char c = Peek();
    if (c == '\'') return Text();
    if (std::isdigit(static_cast<unsigned char>(c)) != 0 || c == '.') return Number();
    if (IsNameStart(c)) return NameAtom();
    Fail(at_ < text_.size() ? "expected a value" : "expected a value at the end");
    return 0;
  }

  Index Text() {
    const std::size_t end = text_.find('\'', at_ + 1);
    if (end == std::string_view::npos) {
      Fail("the text has no closing quotation mark (')");
      return 0;
    }
    const Index made = Add(Code::kText, 0, 0);
    At(made).text = text_.substr(at_ + 1, end - at_ - 1);
    Advance(end + 1 - at_);
    return made;
  }

  Index Number() {
    const std::string_view rest = text_.substr(at_);
    double number = 0;
    std::size_t size = 0;
    if (rest.starts_with("0x") || rest.starts_with("0X")) {
      std::uint64_t whole = 0;
      const auto [end, code] =
          std::from_chars(rest.data() + 2, rest.data() + rest.size(), whole, 16);
      if (code == std::errc()) size = static_cast<std::size_t>(end - rest.data());
      number = static_cast<double>(whole);
    } else {
      const auto [end, code] = std::from_chars(rest.data(), rest.data() + rest.size(), number);
      if (code == std::errc()) size = static_cast<std::size_t>(end - rest.data());
      // The dots of "1..2" are an operator.
      if (size > 1 && rest[size - 1] == '.' && rest.substr(size).starts_with(".")) --size;
    }
    if (size == 0 || (size < rest.size() && IsNameStart(rest[size]))) {
      Fail("expected a number such as 2, 0.5, 1e3 or 0x1F");
      return 0;
    }
    const Index made = Add(Code::kNumber, 0, 0);
    At(made).number = number;
    Advance(size);
    return made;
  }

  Index NameAtom() {
    std::size_t end = at_;
    while (end < text_.size() &&
           (IsNameStart(text_[end]) || std::isdigit(static_cast<unsigned char>(text_[end])) != 0)) {
      ++end;
    }
    const std::string_view name = text_.substr(at_, end - at_);
    const auto known = enums_.find(name);
    Index made = 0;
    if (name == "true" || name == "false" || known != enums_.end()) {
      made = Add(Code::kNumber, 0, 0);
      At(made).number = known != enums_.end() ? known->second : name == "true" ? 1 : 0;
    } else {
      made = Add(Code::kEntry, 0, 0);
      At(made).entry = &board_.At(name);
      script_.reads_.push_back(At(made).entry);
    }
    Advance(end - at_);
    return made;
  }

  // '@' is the beginning of a key of the main tree; bytes beyond ASCII are letters.
  static bool IsNameStart(char c) {
    return std::isalpha(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '@' ||
           static_cast<unsigned char>(c) >= 0x80;
  }
  void Unread(const Entry* entry) {
    const auto last = std::find(script_.reads_.rbegin(), script_.reads_.rend(), entry);
    if (last != script_.reads_.rend()) script_.reads_.erase(std::next(last).base());
  }

  struct DepthGuard {
    explicit DepthGuard(ScriptParser& of) : parser(of) {
      if (++parser.depth_ > kDeepest) parser.Fail("the expression is nested too deeply");
    }
    ~DepthGuard() { --parser.depth_; }
    DepthGuard(const DepthGuard&) = delete;
    DepthGuard& operator=(const DepthGuard&) = delete;
    ScriptParser& parser;
  };

  Index Add(Code code, Index a, Index b) {
    script_.operations_.push_back({.code = code, .a = a, .b = b});
    depths_.push_back(1);
    const auto made = static_cast<Index>(script_.operations_.size() - 1);
    if (code > Code::kEntry) Deepen(made, a);
    if (code > Code::kNot) Deepen(made, b);
    return made;
  }
  // `inside` is evaluated within `index`.
  void Deepen(Index index, Index inside) {
    if (failed_) return;
    depths_[index] = std::max(depths_[index], depths_[inside] + 1);
    if (depths_[index] > kDeepestOperation) Fail("the expression is nested too deeply");
  }
  Script::Operation& At(Index index) {
    if (script_.operations_.empty()) Add(Code::kNumber, 0, 0);  // after an error
    return script_.operations_[index];
  }
  char Peek(std::size_t further = 0) const {
    return at_ + further < text_.size() ? text_[at_ + further] : '\0';
  }
  void Advance(std::size_t bytes) {
    at_ += bytes;
    Skip();
  }
  void Skip() {
    while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_])) != 0) ++at_;
  }
  bool Take(std::string_view sign) {
    if (!text_.substr(at_).starts_with(sign)) return false;
    Advance(sign.size());
    return true;
  }
  void Fail(std::string what) {
    if (!failed_) found_.push_back({at_, true, std::move(what)});
    failed_ = true;
  }
  void Warn(std::string what) { found_.push_back({at_, false, std::move(what)}); }

  const std::string_view text_;
  Board& board_;
  const Enums& enums_;
  const bool is_condition_;
  std::vector<Script::Finding>& found_;
  Script script_;
  std::vector<std::uint32_t> depths_;  // by operation
  std::size_t at_ = 0;
  int depth_ = 0;
  bool failed_ = false;
};

Script Script::Parse(std::string_view text, Board& board, const Enums& enums, bool is_condition,
                     std::vector<Finding>& findings) {
  return ScriptParser(text, board, enums, is_condition, findings).Parse();
}

}  // namespace musher::tree
