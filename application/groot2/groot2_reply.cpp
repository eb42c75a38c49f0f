#include "musher/application/groot2/groot2_reply.hpp"

#include <cstdint>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string_view>

#include "musher/behavior/tree/write_tree.hpp"

namespace musher::groot2 {
namespace {

constexpr std::size_t kHeader = 6;
constexpr std::uint8_t kIdleAfter = 10;

Parts ErrorReply(const std::string& why) {
  return {"error", why};
}

std::string StatusOf(const tree::Tree& tree) {
  std::string bytes;
  bytes.reserve(3 * tree.size());
  for (tree::NodeId id = 0; id < tree.size(); ++id) {
    const std::uint32_t uid = id + 1;
    auto status = static_cast<std::uint8_t>(tree.status(id));
    const tree::NodeRuns& runs = tree.runs(id);
    if (status == 0 && runs.starts > 0) {
      const tree::Status before =
          runs.last == tree::Status::kIdle ? tree::Status::kRunning : runs.last;
      status = static_cast<std::uint8_t>(kIdleAfter + static_cast<std::uint8_t>(before));
    }
    bytes +=
        {static_cast<char>(uid & 0xff), static_cast<char>(uid >> 8), static_cast<char>(status)};
  }
  return bytes;
}

nlohmann::json ToJson(const tree::Value& value) {
  if (value.empty()) return nullptr;
  if (const bool* truth = value.As<bool>()) return *truth;
  if (const std::string* text = value.Text()) return *text;
  double number = 0;
  if (value.ToNumber(number)) {
    const bool real =
        value.type() == tree::TypeOf<double>() || value.type() == tree::TypeOf<float>();
    if (real || !tree::Fits<std::int64_t>(number)) return number;
    return static_cast<std::int64_t>(number);
  }
  return value.Shown();
}

// Null where it has no entries.
nlohmann::json ToJson(tree::Board& board) {
  nlohmann::json entries;
  for (const std::string& key : board.Keys()) {
    const tree::Entry* entry = board.Find(key);
    if (entry != nullptr) entries[key] = ToJson(entry->value);
  }
  return entries;
}

std::string Boards(tree::Tree& tree, const std::string& wanted) {
  nlohmann::json boards;
  std::map<std::string, tree::NodeId> subtrees;
  for (const auto& [id, path] : tree::SubtreePaths(tree)) subtrees.emplace(path, id);
  std::istringstream names(wanted + ";");
  for (std::string name; std::getline(names, name, ';');) {
    const auto subtree = subtrees.find(name);
    if (name.empty() || name == tree.name()) {
      boards[name] = ToJson(tree.board());
    } else if (subtree != subtrees.end() && subtree->second + 1 < tree.size()) {
      boards[name] = ToJson(tree.board(subtree->second + 1));  // its first node has its board
    }
  }
  const std::vector<std::uint8_t> bytes = nlohmann::json::to_msgpack(boards);
  return {bytes.begin(), bytes.end()};
}

}  // namespace

Parts Reply(const Parts& request, const TreeView& view, const tree::Factory& factory,
            const TreeId& tree_id) {
  if (request.empty() || request[0].size() != kHeader) return ErrorReply("wrong request header");
  const char type = request[0][1];
  std::string header = request[0];
  header[0] = kProtocol;
  header.append(tree_id.data(), tree_id.size());
  if (std::string_view("IRUDAXrt").find(type) != std::string_view::npos) return {header};
  if (type == 'T' || type == 'S' || type == 'B') {
    if (view.tree == nullptr) return ErrorReply("no tree is loaded");
    if (view.tree->size() >= std::numeric_limits<std::uint16_t>::max()) {
      return ErrorReply("the tree has more nodes than this protocol can number");
    }
  }
  switch (type) {
    case 'T':
      return {header,
              tree::WriteTree(*view.tree, *view.document, {.with_ids = true, .models = &factory})};
    case 'S':
      return {header, StatusOf(*view.tree)};
    case 'B':
      if (request.size() != 2) return ErrorReply("must be 2 parts message");
      return {header, Boards(*view.tree, request[1])};
    default:
      return ErrorReply("Request not recognized");
  }
}

}  // namespace musher::groot2
