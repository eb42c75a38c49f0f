#pragma once
// The figures of the searches: a table as text, and files in the folder MUSHER_REPORT_DIR.

#include <map>
#include <string>
#include <utility>

#include "musher/search/explorer.hpp"

namespace musher::search {

class FiguresTable {
 public:
  // The figures of one machine from one state; each has a file "search-<name>.json" of its own, so
  // that tests can run in parallel.
  void Add(const std::string& scenario, const State& from, int faults, const Figures& figures);

  // One line for each machine and number of faults, as Markdown.
  std::string Text() const;
  // Prints it, and writes it to "search.md".
  void Publish() const;

 private:
  std::map<std::pair<std::string, int>, Figures> rows_;
};

}  // namespace musher::search
