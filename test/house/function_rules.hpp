#pragma once
// A function that is too long for one screen is read by scrolling. It is cut where a thought ends,
// into parts with names of their own.

#include "musher/test/house/source_tree.hpp"

namespace musher::house {

// Functions with more than 69 lines, from the first one of their head to their closing brace. The
// file must be formatted by clang-format: the indentation shows what a brace closes. Not found: one
// whose body is a `try`, or whose result is written with `struct`; a lambda of a namespace; and one
// with a block comment at its margin.
std::vector<std::string> LongFunctions(const SourceFile& file);

}  // namespace musher::house
