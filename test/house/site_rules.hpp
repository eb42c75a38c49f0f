#pragma once
// The site of the documentation, as far as it can be checked without building it.

#include "musher/test/house/source_tree.hpp"

namespace musher::house {

// Pages (*.md) that no list of links of a branch page has: those named in BRANCHES of
// docs/site/contents.py, from which the tree of contents is made.
std::vector<std::string> PagesOutsideTheContents(const std::vector<SourceFile>& tree);

// Code blocks of `translated` that are not those of `section` of `original`, in the same order.
// `section` empty: of all of it.
std::vector<std::string> DifferingBlocks(const SourceFile& original, const std::string& section,
                                         const SourceFile& translated);

// Headings of `translated` that are not one for one those of `original`, of the same depths.
std::vector<std::string> DifferingHeadings(const SourceFile& original,
                                           const SourceFile& translated);

// Headers that a page of docs/api shows ("```{header} base/log.hpp") and that do not exist, or
// whose comment at the top has no "Threads:".
std::vector<std::string> HeadersWithoutThreads(const std::vector<SourceFile>& tree);

// Drawings of Graphviz in docs/ that fit no printed page: A4, upright or not, with margins of
// 36 pt.
std::vector<std::string> DrawingsThatFitNoPage(const std::vector<SourceFile>& tree);

}  // namespace musher::house
