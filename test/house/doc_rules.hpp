#pragma once
// Documents that cannot rot: their code is cut from files that are compiled and run, and their
// links lead somewhere.
//
// Code in a document stands below a line that says where it comes from:
//
//   <!-- examples/first_module/robot.toml -->            the whole file
//   <!-- examples/first_module/gripper.hpp [class] -->   the lines between "// [class]" and
//                                                        "// [class end]", moved to the left
//   <!-- examples/first_module/gripper.hpp +[class] -->  the same, indented as in the file: the
//                                                        next part of it that a reader types
//                                                        (test/docs/page.py)

#include "musher/test/house/source_tree.hpp"

namespace musher::house {

// Code in `document` (C++, Python, CMake, TOML, XML) that differs from its file in `tree`, or names
// none.
std::vector<std::string> StaleSnippets(const SourceFile& document,
                                       const std::vector<SourceFile>& tree);

// Keys of a TOML file, or fields of an IDL file, that `document` does not name as `code`.
std::vector<std::string> Unexplained(const SourceFile& document, const SourceFile& source);

// Relative links of `document` to files that are not in `tree`.
std::vector<std::string> DeadLinks(const SourceFile& document, const std::vector<SourceFile>& tree);

// The tests in `tree`, as `Suite.Name`.
std::set<std::string> TestsOf(const std::vector<SourceFile>& tree);

// Those that `document` cites and that are not among `tests`.
std::vector<std::string> MissingTests(const SourceFile& document,
                                      const std::set<std::string>& tests);

}  // namespace musher::house
