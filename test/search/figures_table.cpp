#include "musher/test/search/figures_table.hpp"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <sstream>

namespace musher::search {
namespace {

void Write(const std::string& name, const std::string& text) {
  const char* folder = std::getenv("MUSHER_REPORT_DIR");
  if (folder == nullptr) return;
  std::filesystem::create_directories(folder);
  std::ofstream(std::filesystem::path(folder) / name) << text;
}

}  // namespace

void FiguresTable::Add(const std::string& scenario, const State& from, int faults,
                       const Figures& figures) {
  rows_[{scenario, faults}] += figures;
  std::ostringstream json;
  json << "{\"machine\": \"" << scenario << "\", \"from\": \"" << from
       << "\", \"faults\": " << faults << ", \"pairs\": " << figures.pairs
       << ", \"nodes\": " << figures.nodes << ", \"transitions\": " << figures.transitions
       << ", \"leaves\": " << figures.leaves << ", \"seconds\": " << figures.seconds << "}\n";
  Write("search-" + scenario + "-" + from + "-" + std::to_string(faults) + ".json", json.str());
}

std::string FiguresTable::Text() const {
  std::ostringstream text;
  text << "| machine | faults | pairs | nodes | transitions | leaves | seconds |\n"
       << "|---|---|---|---|---|---|---|\n";
  for (const auto& [key, figures] : rows_) {
    text << "| " << key.first << " | up to " << key.second << " | " << figures.pairs << " | "
         << figures.nodes << " | " << figures.transitions << " | " << figures.leaves << " | "
         << std::fixed << std::setprecision(1) << figures.seconds << " |\n";
  }
  return text.str();
}

void FiguresTable::Publish() const {
  if (rows_.empty()) return;
  std::cout << Text();
  Write("search.md", Text());
}

}  // namespace musher::search
