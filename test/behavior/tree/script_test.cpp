// The scripting language.

#include "musher/test/behavior/tree/scripts.hpp"
#include "musher/test/behavior/tree/trees.hpp"

namespace musher::tree::script_test {

struct Scripts : testing::Test, ScriptRunner {
  using ScriptRunner::Run;
};

TEST_F(Scripts, Calculate) {
  EXPECT_EQ(Run("1 + 2 * 3 - 8 / 4"), "5");
  EXPECT_EQ(Run("-(1 + 2) * 2"), "-6");
  EXPECT_EQ(Run("0x1F + 1e2 + .5"), "131.5");
  EXPECT_EQ(Run("7 & 3 | 8 ^ 1"), "10");
  EXPECT_EQ(Run("~5"), "-6");
  EXPECT_EQ(Run("'a' + 'b'"), "'ab'");
}
TEST_F(Scripts, Compare) {
  EXPECT_EQ(Run("1 < 2 && 2 <= 2 && 3 != 4"), "1");
  EXPECT_EQ(Run("0 < 5 < 3"), "0");
  EXPECT_EQ(Run("0 < 2 < 3"), "1");
  EXPECT_EQ(Run("'abc' == 'abc' && 'a' < 'b'"), "1");
  EXPECT_EQ(Run("!true || false"), "0");
  EXPECT_EQ(Run("0.1 + 0.2 == 0.3"), "1");
  EXPECT_EQ(Run("RED + BLUE"), "3");
}
// A condition that compares two numbers is evaluated in a shorter way.
TEST_F(Scripts, AreTrueWhereTheirValueIsNot0) {
  board.At("n").type = TypeOf<int>();
  ASSERT_EQ(Run("x := 2.0; t := '2'; n := 2"), "2");
  const std::vector<std::string> operands = {"x", "n", "t", "2", "3", "RED", "2.00000001", "-x"};
  for (const std::string sign : {"==", "!=", "<", ">", "<=", ">="}) {
    for (const std::string& left : operands) {
      for (const std::string& right : operands) {
        const std::string text = left + " " + sign + " " + right;
        const Script script = Script::Parse(text, board, enums, true, findings);
        EXPECT_EQ(script.True(), script.Evaluate().number() != 0) << text;
      }
    }
  }
  EXPECT_TRUE(findings.empty());
}
TEST_F(Scripts, AConditionFollowsItsEntry) {
  const Script script = Script::Parse("0 < x", board, enums, true, findings);
  EXPECT_THROW(static_cast<void>(script.True()), ScriptError) << "it has no value";
  Run("x := 1");
  EXPECT_TRUE(script.True());
  Run("x := 0");
  EXPECT_FALSE(script.True());
}
TEST_F(Scripts, Choose) {
  EXPECT_EQ(Run("2 > 1 ? 'yes' : 'no'"), "'yes'");
  EXPECT_EQ(Run("false ? 1 : true ? 2 : 3"), "2");
}
TEST_F(Scripts, Assign) {
  EXPECT_EQ(Run("x := 3; y := x * 2; y += 1; y -= 3; y *= 10; y /= 4"), "10");
  EXPECT_EQ(Run("t := 'a'; t += 'b'; t"), "'ab'");
  EXPECT_EQ(Run("x = 7; x"), "7");
  EXPECT_EQ(Run("a := b := 2; a + b"), "4");
  EXPECT_EQ(Run("t + (t := 'something that is longer than before') == t"), "0");
}
TEST_F(Scripts, AnEqualsSignNeedsAnEntry) {
  EXPECT_EQ(Run("none = 1"), "the blackboard has no value of 'none'; to make an entry, use ':='");
  EXPECT_EQ(Run("none + 1"), "the blackboard has no value of 'none'");
}
TEST_F(Scripts, ConvertToTheTypeOfTheEntry) {
  board.At("n").type = TypeOf<int>();
  EXPECT_EQ(Run("n := 3; n"), "3");
  EXPECT_EQ(*board.At("n").value.As<int>(), 3);
  EXPECT_EQ(Run("n := '12'; n"), "12");
  EXPECT_EQ(Run("n := 2.5"), "'n': 2.5 is not valid: expected integer");
  EXPECT_EQ(Run("n := 'x'"), "'n': 'x' is not valid: expected integer");
  EXPECT_EQ(Run("n"), "12");
}
TEST_F(Scripts, RefuseWhatDoesNotFit) {
  EXPECT_EQ(Run("'a' - 1"), "'-' needs numbers; got 'a'");
  EXPECT_EQ(Run("1.5 & 1"), "'&' needs whole numbers; got 1.5");
  EXPECT_EQ(Run("x := 'a'; x == 1"), "can not compare 'a' with 1");
  EXPECT_EQ(Run("'a' && true"), "expected true or false, or a number; got 'a'");
}
TEST_F(Scripts, NameThePlaceOfASyntaxError) {
  EXPECT_EQ(Run("1 +"), "3: expected a value at the end");
  EXPECT_EQ(Run("(1 + 2"), "6: expected ')'");
  EXPECT_EQ(Run("x := 'a"), "5: the text has no closing quotation mark (')");
  EXPECT_EQ(Run("1 2"), "2: expected an operator or ';'");
  EXPECT_EQ(Run("3 := 4"), "2: only an entry of the blackboard can be assigned to");
  EXPECT_EQ(Run("x ? 1"), "5: expected ':' of 'condition ? value : value'");
  EXPECT_EQ(Run(""), "0: the script is empty");
  EXPECT_EQ(Run("2x"), "0: expected a number such as 2, 0.5, 1e3 or 0x1F");
  EXPECT_THAT(Run(std::string(1000, '(')), testing::HasSubstr("nested too deeply"));
  EXPECT_THAT(Run(std::string(1000, '-')), testing::HasSubstr("nested too deeply"));
}
TEST_F(Scripts, ReachTheMainTreeByAnAtSign) {
  Board inner(board, false);
  Script::Parse("@x := 5", inner, enums, false, findings).Run();
  EXPECT_EQ(board.Get<int>("x").value(), 5);
}

}  // namespace musher::tree::script_test
