#include "musher/test/house/function_rules.hpp"

#include <gmock/gmock.h>

namespace musher::house::function_rules_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

std::string Repeat(int times, const std::string& line) {
  std::string text;
  for (int i = 0; i < times; ++i) text += line;
  return text;
}

std::vector<std::string> LongIn(const std::string& text) {
  return LongFunctions({"a.cpp", text});
}

TEST(FunctionRules, FindAFunctionThatIsTooLong) {
  EXPECT_THAT(LongIn("\nint A() {\n" + Repeat(67, "  a();\n") + "}\n"), IsEmpty());
  EXPECT_THAT(LongIn("\nint A() {\n" + Repeat(68, "  a();\n") + "}\n"),
              ElementsAre("a.cpp:2: has 70 lines, of at most 69: int A() {"));
}

TEST(FunctionRules, CountTheHeadAndTheInitializersOfAConstructor) {
  const std::string head = "A::A(int a,\n     int b)\n    : a_(a),\n      b_(b) {\n";
  EXPECT_THAT(LongIn(head + Repeat(64, "  a();\n") + "}\n"), IsEmpty());
  EXPECT_THAT(LongIn(head + Repeat(65, "  a();\n") + "}\n"),
              ElementsAre("a.cpp:1: has 70 lines, of at most 69: A::A(int a,"));
}

TEST(FunctionRules, FindOneInsideOfAClass) {
  EXPECT_THAT(
      LongIn("class A {\n public:\n  void B() const {\n" + Repeat(70, "    a();\n") + "  }\n};\n"),
      ElementsAre("a.cpp:3: has 72 lines, of at most 69: void B() const {"));
}

TEST(FunctionRules, FindOneWithACommentBehindItsClosingBrace) {
  EXPECT_THAT(LongIn("void A() {\n" + Repeat(70, "  a();\n") + "}  // of A\n"), SizeIs(1));
  EXPECT_THAT(LongIn("void A();\n" + Repeat(70, "\n") + "}  // namespace a\n"), IsEmpty());
}

TEST(FunctionRules, BlocksTypesAndTablesAreNoFunctions) {
  const std::string many = Repeat(70, "    a();\n");
  for (const char* head : {"if (a) {", "} else {", "for (;;) {", "switch (a()) {", "struct A {",
                           "{", "namespace a {", "const int* const kA = {"}) {
    EXPECT_THAT(LongIn("  " + std::string(head) + "\n" + many + "  }\n"), IsEmpty()) << head;
  }
  EXPECT_THAT(LongIn("const auto kTable = Table({\n" + many + "});\n"), IsEmpty());
}

TEST(FunctionRules, WhatARawStringHasAtTheMarginClosesNothing) {
  EXPECT_THAT(LongIn("void A() {\n  B(R\"json({\n}\n" + Repeat(70, "1,\n") + "{)json\");\n}\n"),
              SizeIs(1));
  EXPECT_THAT(LongIn("void A() {\n#ifdef B\n  b();\n#endif\n" + Repeat(70, "\n") + "}\n"),
              SizeIs(1));
}

}  // namespace musher::house::function_rules_test
