#pragma once
// What was searched, in figures: a table for people, and files where MUSHER_REPORT_DIR says.

#include <map>
#include <string>
#include <utility>

#include "musher/test/search/explorer.hpp"

namespace musher::search {

class FiguresTable {
 public:
  // Of one machine from one state; a file "search-<name>.json" of its own, so that tests may run in
  // parallel.
  void Add(const std::string& scenario, const State& from, int faults, const Figures& figures);

  // One line for each machine and number of faults, as Markdown.
  std::string Text() const;
  // Prints it, and writes it to "search.md".
  void Publish() const;

 private:
  std::map<std::pair<std::string, int>, Figures> rows_;
};

}  // namespace musher::search
