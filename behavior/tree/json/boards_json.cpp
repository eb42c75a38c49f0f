#include "musher/behavior/tree/json/boards_json.hpp"

#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include "musher/base/suggest.hpp"
#include "musher/behavior/tree/json/json_places.hpp"

namespace musher::tree {
namespace {

using OrderedJson = nlohmann::ordered_json;

// Nothing: the value has no JSON.
std::optional<OrderedJson> ToJson(const Value& value) {
  if (value.empty()) return OrderedJson(nullptr);
  if (const auto* truth = value.As<bool>()) return OrderedJson(*truth);
  if (const auto* text = value.Text()) return OrderedJson(*text);
  if (const auto* whole = value.As<std::int64_t>()) return OrderedJson(*whole);
  if (const auto* whole = value.As<std::uint64_t>()) return OrderedJson(*whole);
  if (const auto text = value.Json()) {
    OrderedJson json = OrderedJson::parse(*text, nullptr, false);
    if (json.is_discarded()) return std::nullopt;
    return json;
  }
  double number = 0;
  if (!value.ToNumber(number)) return std::nullopt;
  return Fits<std::int64_t>(number) ? OrderedJson(static_cast<std::int64_t>(number))
                                    : OrderedJson(number);
}

// `type` null: any. A null of JSON is an empty value.
Result<Value> FromJson(const OrderedJson& json, const Type* type) {
  Value value;
  if (json.is_null()) return value;
  if (json.is_boolean()) value.Set(json.get<bool>());
  if (json.is_string()) value.Set(json.get<std::string>());
  if (json.is_number_float()) value.Set(json.get<double>());
  if (json.is_number_unsigned()) value.Set(json.get<std::uint64_t>());
  // Exact, where the entry has 64 bits with a sign.
  if (json.is_number_integer() && (value.empty() || type == TypeOf<std::int64_t>())) {
    const auto whole = json.get<std::int64_t>();
    if (value.empty() || whole >= 0) value.Set(whole);
  }
  if (json.is_structured()) {
    if (type == nullptr) {
      return Error{kCodeFailed, "no port gives the entry a type that has JSON"};
    }
    value.Set("json:" + json.dump());
  }
  if (type == nullptr) {
    double number = 0;
    if (json.is_number() && value.ToNumber(number)) value.Set(number);
    return value;
  }
  Value fitting;
  const Result<> fits = fitting.SetAs(*type, value);
  if (!fits) return fits.error();
  return fitting;
}

std::vector<std::pair<std::string, Board*>> BoardsOf(const Tree& tree) {
  std::vector<std::pair<std::string, Board*>> boards;
  std::set<const Board*> done;
  for (NodeId id = 0; id < tree.size(); ++id) {
    const NodeInfo& info = tree.info(id);
    Board& board = *tree.boards()[info.board];
    if (!done.insert(&board).second) continue;
    boards.emplace_back(info.parent == kNoNode ? tree.name() : tree.Path(info.parent), &board);
  }
  return boards;
}

OrderedJson Parsed(std::string_view text, const std::string& file, std::vector<Diagnostic>& found) {
  if (internal::IsTooLargeJson(text)) {
    found.push_back(
        {file, 0, 0, Severity::kError, "the JSON is larger than 1 MiB, or nested deeper than 100"});
    return {};
  }
  try {
    return OrderedJson::parse(text);
  } catch (const OrderedJson::parse_error& error) {
    found.push_back(internal::JsonDiagnostic(text, file, error.byte == 0 ? 0 : error.byte - 1,
                                             Severity::kError, "it is no JSON"));
    return {};
  }
}

}  // namespace

std::string BoardsToJson(const Tree& tree) {
  OrderedJson json = OrderedJson::object();
  for (const auto& [path, board] : BoardsOf(tree)) {
    OrderedJson& entries = json[path] = OrderedJson::object();
    for (const std::string& key : board->Keys()) {
      if (!board->Owns(key)) continue;
      if (auto value = ToJson(board->Find(key)->value)) entries[key] = std::move(*value);
    }
  }
  return json.dump(2, ' ', false, OrderedJson::error_handler_t::replace);
}

std::vector<Diagnostic> BoardsFromJson(Tree& tree, std::string_view text, const std::string& file) {
  std::vector<Diagnostic> found;
  const OrderedJson json = Parsed(text, file, found);
  if (!found.empty()) return found;
  const internal::JsonPlaces places(text);
  const auto fail = [&](std::size_t byte, std::string what) {
    found.push_back(internal::JsonDiagnostic(text, file, byte, Severity::kError, std::move(what)));
  };
  if (!json.is_object()) return fail(0, "expected an object with the boards"), found;
  std::map<std::string, Board*> boards;
  std::vector<std::string> paths;
  for (const auto& [path, board] : BoardsOf(tree)) {
    boards.emplace(path, board);
    paths.push_back(path);
  }
  std::vector<std::tuple<Board*, std::string, Value>> values;
  for (const auto& [path, entries] : json.items()) {
    const auto board = boards.find(path);
    if (board == boards.end()) {
      fail(places.At({path}).name, "there is no tree '" + path + "'" + DidYouMean(path, paths));
      continue;
    }
    if (!entries.is_object()) {
      fail(places.At({path}).value, "expected an object with the entries of '" + path + "'");
      continue;
    }
    for (const auto& [key, value] : entries.items()) {
      const Entry* entry = board->second->Find(key);
      Result<Value> made = FromJson(value, entry == nullptr ? nullptr : entry->type);
      if (made) {
        values.emplace_back(board->second, key, std::move(made).value());
      } else {
        fail(places.At({path, key}).value, "entry '" + key + "': " + made.error().message);
      }
    }
  }
  if (!found.empty()) return found;
  for (auto& [board, key, value] : values) {
    Entry& entry = board->At(key);
    if (value.empty()) {
      entry.value.Clear();
    } else {
      static_cast<void>(entry.Assign(value));  // it is of the entry's type
    }
  }
  return found;
}

}  // namespace musher::tree
