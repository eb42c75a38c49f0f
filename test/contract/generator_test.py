"""The generator of messages/ refuses IDL that is not of the form that messages/README.md describes, with its place."""

import os
import subprocess
import sys
import tempfile
import unittest

SOURCE = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
GENERATE = os.path.join(SOURCE, "messages", "generator", "generate.py")


def in_modules(*lines):
    return "\n".join(["module a { module msg { module dds_ {", *lines, "}; }; };", ""])


GOOD = in_modules("  @final struct Good_ {", "    int32 x;", "  };")


def generate(**files):
    """(what it prints about its failure, what it has written)"""
    with tempfile.TemporaryDirectory() as folder:
        names = []
        for name, text in files.items():
            names.append(f"a/{name}.idl")
            os.makedirs(os.path.join(folder, "a"), exist_ok=True)
            with open(os.path.join(folder, names[-1]), "w", encoding="utf-8") as file:
                file.write(text)
        ended = subprocess.run([sys.executable, "-B", GENERATE, "headers", "--root", folder, "--out", folder, *names],
                               capture_output=True, text=True, check=False)
        made = {}
        for name in files:
            path = os.path.join(folder, "musher", "messages", "a", f"{name}.hpp")
            if os.path.exists(path):
                with open(path, encoding="utf-8") as file:
                    made[name] = file.read()
        return ended.stderr.strip(), made


class Generator(unittest.TestCase):
    def refuses(self, expected, **files):
        error, made = generate(**files)
        self.assertIn(expected, error)
        self.assertEqual(made, {})

    def test_a_struct_that_is_not_final(self):
        self.refuses("x.idl:2: 'X_' is not @final", x=in_modules("  struct X_ {", "    int32 x;", "  };"))

    def test_a_struct_outside_of_the_modules(self):
        self.refuses("x.idl:1: this belongs into the modules", x="@final struct X_ {\n  int32 x;\n};\n")

    def test_an_unknown_type(self):
        self.refuses("x.idl:3: 'wstring' is no type",
                     x=in_modules("  @final struct X_ {", "    wstring x;", "  };"))

    def test_a_line_that_is_no_declaration(self):
        self.refuses("x.idl:2: 'enum E { A };' is not a declaration", x=in_modules("  enum E { A };"))

    def test_a_missing_brace(self):
        self.refuses("x.idl: a '}' is missing", x=GOOD.replace("}; }; };", ""))

    def test_a_type_that_is_not_declared_before(self):
        self.refuses("X.y is a a::msg::dds_::Y_, which is not declared before",
                     x=in_modules("  @final struct X_ {", "    Y_ y;", "  };"))

    def test_an_include_that_is_not_there(self):
        self.refuses("a/x.idl: there is no a/y.idl", x='#include "a/y.idl"\n' + GOOD)

    def test_files_that_include_each_other(self):
        self.refuses("a/x.idl includes a/y.idl includes a/x.idl",
                     x='#include "a/y.idl"\n' + GOOD, y='#include "a/x.idl"\n' + GOOD)

    def test_a_request_without_a_response(self):
        self.refuses("a/srv/Do has no Response", x="module a { module srv { module dds_ {\n"
                     "  @final struct Do_Request_ {\n    int32 x;\n  };\n}; }; };\n")

    def test_a_constant_with_the_name_of_a_keyword(self):
        self.refuses("x.idl:3: 'DOUBLE' is a keyword",
                     x=in_modules("  module X_Constants {", "    const int32 DOUBLE = 3;", "  };"))

    def test_a_comment_that_would_be_lost(self):
        for lines in (["  @final struct X_ {  // lost", "    int32 x;", "  };"],
                      ["  @final struct X_ {", "    int32 x;", "    // lost", "  };"],
                      ["  // lost", "", "  @final struct X_ {", "    int32 x;", "  };"]):
            self.refuses("the comment 'lost'", x=in_modules(*lines))

    def test_two_interfaces_of_one_name_in_cpp(self):
        self.refuses("a/msg/Y and a/msg/Good are both 'Good' in C++",
                     x=GOOD, y=in_modules('  @final @cpp_name("Good") struct Y_ {', "    int32 x;", "  };"))

    def test_a_good_file_becomes_a_header(self):
        error, made = generate(good=in_modules(
            "  module Good_Constants {", "    const uint8 RGB_ON = 0x01;  // a light", "  };",
            "  // A good one.", "  @final struct Good_ {", "    @default(-1) int32 x;  // m",
            "    @appended sequence<string> y;", "  };"))
        self.assertEqual(error, "")
        for line in ["// a/msg/Good\n// A good one.\nstruct Good {", "  static constexpr std::uint8_t kRgbOn = 0x01;  // a light",
                     "  std::int32_t x = -1;  // m", "  std::vector<std::string> y{};", "kAppended = 1;",
                     "return std::tie(m.x, m.y);"]:
            self.assertIn(line, made["good"])

    def test_an_action_without_a_part(self):
        self.refuses("a/action/Do has no Result", x="module a { module action { module dds_ {\n"
                     "  @final struct Do_Goal_ {\n    int32 x;\n  };\n}; }; };\n")

    def test_an_action_becomes_a_struct_of_its_parts(self):
        parts = ["Goal", "Result", "Feedback", "SendGoal_Request", "SendGoal_Response", "GetResult_Request",
                 "GetResult_Response", "FeedbackMessage"]
        lines = [line for part in parts
                 for line in (f"  @final struct Do_{part}_ {{", "    int32 x;", "  };")]
        error, made = generate(do="\n".join(["module a { module action { module dds_ {", *lines, "}; }; };", ""]))
        self.assertEqual(error, "")
        for line in ["struct Do {\n  static constexpr std::string_view kTypeName = \"a::action::dds_::Do_\";",
                     "  struct Goal {", "\"a::action::dds_::Do_SendGoal_\"", "\"a::action::dds_::Do_GetResult_\"",
                     "\"a::action::dds_::Do_FeedbackMessage_\""]:
            self.assertIn(line, made["do"])


if __name__ == "__main__":
    unittest.main()
