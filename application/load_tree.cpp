#include "musher/application/load_tree.hpp"

#include "musher/base/code.hpp"
#include "musher/behavior/tree/xml/tree_xml.hpp"

namespace musher {
namespace {

void WarnOf(const std::vector<Diagnostic>& diagnostics, const Warn& warn) {
  for (const Diagnostic& each : diagnostics) {
    if (each.severity != Severity::kError) warn(FormatDiagnostic(each));
  }
}

}  // namespace

std::string ErrorLines(const std::vector<Diagnostic>& diagnostics) {
  std::string lines;
  for (const Diagnostic& each : diagnostics) {
    if (each.severity != Severity::kError) continue;
    lines += (lines.empty() ? "" : "\n") + FormatDiagnostic(each);
  }
  return lines;
}

Result<tree::Document> ReadTreeDocument(const std::string& file, const Warn& warn) {
  tree::Reading read = tree::ReadTreeFile(file);
  if (!read.ok()) return Error{kCodeParametersInvalid, ErrorLines(read.diagnostics)};
  WarnOf(read.diagnostics, warn);
  return std::move(read.document);
}

Result<std::unique_ptr<tree::Tree>> BuildTree(const tree::Document& document,
                                              const tree::Factory& factory,
                                              const tree::BuildOptions& options, const Warn& warn) {
  tree::Built built = tree::Build(document, factory, options);
  if (built.tree == nullptr) return Error{kCodeParametersInvalid, ErrorLines(built.diagnostics)};
  WarnOf(built.diagnostics, warn);
  return std::move(built.tree);
}

OuterBoardGuard::OuterBoardGuard(tree::Board* board) : board_(board) {
  if (board_ == nullptr) return;
  for (const std::string& key : board_->Keys()) {
    tree::Entry* const entry = board_->Find(key);
    before_.emplace(entry, *entry);
  }
}

OuterBoardGuard::~OuterBoardGuard() {
  if (board_ == nullptr) return;
  for (const std::string& key : board_->Keys()) {
    tree::Entry& entry = *board_->Find(key);
    const auto found = before_.find(&entry);
    if (found != before_.end()) {
      entry = found->second;
      continue;
    }
    entry.type = nullptr;
    entry.value.Clear();
    entry.declared = false;
    entry.sequence = 0;
    entry.set_at = {};
  }
}

Result<> SetEntries(tree::Board& board,
                    const std::vector<std::pair<std::string, std::string>>& entries) {
  std::string wrong;
  for (const auto& [key, value] : entries) {
    tree::Entry* entry = board.Find(key);
    std::string why;
    if (entry == nullptr) {
      why = "no node has a port with this key";
    } else if (const Result<> set = entry->AssignText(value); !set) {
      why = set.error().message;
    }
    if (!why.empty()) wrong += (wrong.empty() ? "entry '" : "\nentry '") + key + "': " + why;
  }
  if (!wrong.empty()) return Error{kCodeParametersInvalid, wrong};
  return Ok();
}

}  // namespace musher
