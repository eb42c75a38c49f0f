// How the build connects attributes with entries of blackboards: ports, conditions, remapping.

#include <algorithm>
#include <charconv>

#include "musher/base/suggest.hpp"
#include "musher/behavior/tree/building.hpp"
#include "musher/behavior/tree/conditions.hpp"

namespace musher::tree {
namespace {

bool IsCondition(std::string_view name) {
  return std::ranges::find(kConditionNames, name) != kConditionNames.end();
}

// Attributes of every element that are no ports.
bool IsReserved(std::string_view name) {
  return name == "name" || name == "ID" || name == "_description" || name == "_autoremap" ||
         name == "_collapsed" || name == "_uid" || name == "_fullpath" || name == "_fullPath" ||
         name == "__shared_blackboard";
}

std::string PortText(const PortModel& model) {
  return "port '" + model.name + "'" +
         (model.type == nullptr ? "" : " (" + std::string(model.type->name) + ")");
}

}  // namespace

Setup::Connection Building::Connect(const Element& element, Board& board, const PortModel& model) {
  const Attribute* attribute = element.Find(model.name);
  if (attribute == nullptr) {
    if (model.required) {
      Report(element.at, Severity::kError,
             "<" + element.name + "> needs " + PortText(model) +
                 (model.doc.empty() ? "" : ": " + model.doc));
    }
    return {};
  }
  MarkUsed(*attribute);
  if (model.direction == Direction::kText) return {nullptr, attribute};
  const auto key = KeyOf(attribute->value, model.name);
  if (key) {
    Entry& entry = board.At(*key);
    entry.declared = true;
    Unify(entry, *attribute, model);
    if (model.direction != Direction::kOut) NoteRead(entry, attribute->value_at);
    if (model.direction != Direction::kIn) NoteWrite(entry, attribute->value_at);
    return {&entry, nullptr};
  }
  if (model.direction == Direction::kInOut) {
    Report(attribute->value_at, Severity::kWarning,
           PortText(model) + " is a fixed text: what is written to it is lost");
  } else if (model.direction == Direction::kOut) {
    Report(attribute->value_at, Severity::kError,
           PortText(model) + " is written; expected an entry, such as \"{" + model.name + "}\"");
    return {};
  }
  return {nullptr, attribute};
}

void Building::Unify(Entry& entry, const Attribute& attribute, const PortModel& model) {
  if (model.type == nullptr) return;
  // Everything that is a text or a number can be read as a text.
  if (model.direction == Direction::kIn && model.type == TypeOf<std::string>()) {
    read_as_text_.insert(&entry);
    return;
  }
  const auto [first, is_first] =
      types_.try_emplace(&entry, FirstUse{model.type, attribute.value_at});
  if (is_first) {
    entry.type = model.type;
    return;
  }
  const Type* known = first->second.type;
  if (entry.type == nullptr || known == model.type) return;
  if (known == TypeOf<std::string>() || model.type == TypeOf<std::string>()) {
    entry.type = nullptr;
    return;
  }
  const Diagnostic at = document_.At(first->second.place, Severity::kNote, "");
  Report(attribute.value_at, Severity::kError,
         PortText(model) + " uses '" + entry.key + "', which is of type " +
             std::string(known->name) + " at " + at.file + ":" + std::to_string(at.line) + ":" +
             std::to_string(at.column));
}

void Building::NoteScript(const Script& script, Place place) {
  for (const Entry* entry : script.reads()) NoteRead(*entry, place);
  for (const Entry* entry : script.writes()) {
    writes_.emplace(entry, place);
    if (std::ranges::find(script.needs(), entry) == script.needs().end()) made_.insert(entry);
  }
  for (const Entry* entry : script.needs()) needed_.emplace_back(entry, place);
}

void Building::CheckAttributes(const Element& element, const Setup& setup) {
  for (const PortModel& port : setup.ports()) {
    if (port.name != "name" && port.name != "ID" && !port.name.starts_with('_')) continue;
    Report(element.at, Severity::kError,
           "node '" + element.name + "' has a port '" + port.name +
               "', which is reserved; give the port another name");
  }
  for (const Attribute& attribute : element.attributes) {
    if (IsReserved(attribute.name) || IsCondition(attribute.name)) continue;
    if (std::ranges::find(used_attributes_, &attribute) != used_attributes_.end()) continue;
    std::vector<std::string> known = {"name"};
    for (const PortModel& port : setup.ports()) known.push_back(port.name);
    const bool special = attribute.name.starts_with('_');
    if (special) known.assign(kConditionNames.begin(), kConditionNames.end());
    Report(attribute.at, special ? Severity::kWarning : Severity::kError,
           (special ? "attribute '" + attribute.name + "' has no meaning"
                    : "<" + element.name + "> has no port '" + attribute.name + "'") +
               DidYouMean(attribute.name, known));
  }
}

void Building::SetConditions(const Element& element, Node& node, Board& board) {
  for (std::size_t i = 0; i < kConditionNames.size(); ++i) {
    const Attribute* attribute = element.Find(kConditionNames[i]);
    if (attribute == nullptr) continue;
    std::vector<Script::Finding> findings;
    Script script =
        Script::Parse(attribute->value, board, factory_.enums(), i < kConditionsBefore, findings);
    for (const Script::Finding& finding : findings) ReportScript(*attribute, finding);
    NoteScript(script, attribute->value_at);
    if (node.conditions_ == nullptr) node.conditions_ = std::make_unique<Conditions>();
    node.conditions_->scripts[i] = std::move(script);
    node.special_ = true;
  }
}

// The board of a subtree, with the keys that the element and the model of the subtree give it.
std::uint32_t Building::MakeBoard(const Element& element, std::string_view id,
                                  std::uint32_t outer_id) {
  Board& outer = *tree_->boards_[outer_id];
  const Attribute* auto_attribute = element.Find("_autoremap");
  bool autoremap = element.name == "SubTreePlus";
  if (auto_attribute != nullptr) {
    const Result<bool> value = Convert<bool>::FromText(auto_attribute->value);
    if (!value) Report(auto_attribute->value_at, Severity::kError, value.error().message);
    autoremap = value && value.value();
  }
  tree_->boards_.push_back(std::make_unique<Board>(outer, autoremap));
  const auto board_id = static_cast<std::uint32_t>(tree_->boards_.size() - 1);
  Board& board = *tree_->boards_.back();
  const auto give = [&](const std::string& name, const std::string& value, Place place,
                        const Attribute* attribute) {
    if (const auto key = KeyOf(value, name)) {
      board.Remap(name, *key);
    } else {
      constants_.push_back({&board.Own(name), attribute, value, place});
    }
  };
  std::vector<std::string> given;
  for (const Attribute& attribute : element.attributes) {
    if (attribute.name == "ID" || attribute.name == "name" || attribute.name.starts_with('_')) {
      if (!IsReserved(attribute.name) && !IsCondition(attribute.name)) {
        Report(attribute.at, Severity::kWarning,
               "attribute '" + attribute.name + "' has no meaning");
      }
      continue;
    }
    give(attribute.name, attribute.value, attribute.value_at, &attribute);
  }
  for (const Element& model : document_.models) {
    const Attribute* model_id = model.Find("ID");
    if (model.name != "SubTree" || model_id == nullptr || model_id->value != id) continue;
    for (const Element& port : model.children) {
      const Attribute* name = port.Find("name");
      if (name == nullptr || element.Find(name->value) != nullptr || autoremap) continue;
      const Attribute* value = port.Find("default");
      if (value != nullptr) {
        give(name->value, value->value, value->value_at, value);
      } else {
        Report(element.at, Severity::kError,
               "<SubTree ID=\"" + std::string(id) + "\"> needs '" + name->value +
                   "', which <TreeNodesModel> declares without a default");
      }
    }
  }
  return board_id;
}

// Fixed texts of subtrees become values once the types of their entries are known: a number where
// the whole text is one, as in BehaviorTree.CPP.
void Building::SetConstants() {
  for (const Constant& constant : constants_) {
    Result<> set;
    const Result<double> number = Convert<double>::FromText(constant.text);
    const auto known = factory_.enums().find(constant.text);
    if (known != factory_.enums().end() && constant.entry->type != TypeOf<std::string>()) {
      set = constant.entry->AssignNumber(known->second);
    } else if (constant.entry->type == nullptr && !read_as_text_.contains(constant.entry) &&
               number) {
      set = constant.entry->AssignNumber(number.value());
    } else {
      set = constant.entry->AssignText(constant.text);
    }
    if (!set) {
      Report(constant.place, Severity::kError,
             "'" + constant.entry->key + "': " + set.error().message);
    }
  }
}

}  // namespace musher::tree
