#include "musher/behavior/tree/setup.hpp"

#include <cctype>

#include "musher/behavior/tree/builder.hpp"

namespace musher::tree {

std::optional<std::string_view> KeyOf(std::string_view value, std::string_view name) {
  const std::string_view text = Trimmed(value);
  if (text.size() < 3 || text.front() != '{' || text.back() != '}') return std::nullopt;
  const std::string_view key = text.substr(1, text.size() - 2);
  return key == "=" ? name : key;
}

Setup::Setup(Builder* builder, const Element& element, Board& board, const Enums& enums)
    : builder_(builder), element_(element), board_(board), enums_(enums) {
  const Attribute* name = element.Find("name");
  name_ = name != nullptr ? name->value : element.name;
}

Setup::Connection Setup::Connect(PortModel model) {
  Connection connection;
  if (builder_ != nullptr) connection = builder_->Connect(element_, board_, model);
  ports_.push_back(std::move(model));
  return connection;
}

Entry* Setup::Key(std::string_view name, std::string_view doc) {
  const Connection connection =
      Connect({std::string(name), Direction::kText, nullptr, true, std::string(doc)});
  if (connection.text == nullptr) return builder_ == nullptr ? nullptr : connection.entry;
  const std::string_view value = connection.text->value;
  Entry& entry = board_.At(KeyOf(value, name).value_or(Trimmed(value)));
  if (name == "output_key") builder_->NoteWrite(entry, connection.text->value_at);
  return &entry;
}

std::string Setup::Text(std::string_view name, bool required, std::string_view doc) {
  const Connection connection =
      Connect({std::string(name), Direction::kText, nullptr, required, std::string(doc)});
  return connection.text == nullptr ? "" : connection.text->value;
}

std::optional<Script> Setup::ScriptOf(std::string_view name, bool is_condition) {
  const Connection connection =
      Connect({std::string(name), Direction::kText, nullptr, true, "a script"});
  if (connection.text == nullptr) return std::nullopt;
  if (KeyOf(connection.text->value, name)) {
    Report(name, Severity::kError,
           "a script is fixed when the tree is loaded; expected its text instead of an entry");
    return std::nullopt;
  }
  std::vector<Script::Finding> findings;
  Script script = Script::Parse(connection.text->value, board_, enums_, is_condition, findings);
  bool failed = false;
  for (Script::Finding& finding : findings) {
    failed |= finding.error;
    builder_->ReportScript(*connection.text, finding);
  }
  if (failed) return std::nullopt;
  builder_->NoteScript(script, connection.text->value_at, true);
  return script;
}

bool Setup::IsName(std::string_view text) {
  return !text.empty() && std::isalpha(static_cast<unsigned char>(text[0])) != 0;
}

std::string Setup::EnumNames() const {
  constexpr std::size_t kMostNames = 20;
  std::string names;
  std::size_t count = 0;
  for (const auto& [name, value] : enums_) {
    if (count++ == kMostNames) return names + ", ...";
    names += (names.empty() ? "" : ", ") + name + " (" + NumberText(value) + ")";
  }
  return names;
}

WakeUp Setup::wake_up() const {
  return builder_ != nullptr ? builder_->wake_up() : WakeUp();
}

void Setup::NoteUnset(const std::string& port) {
  if (builder_ != nullptr) builder_->NoteUnset(element_, port);
}

void Setup::Report(std::string_view attribute, Severity severity, std::string what) {
  if (builder_ == nullptr) return;
  const Attribute* found = element_.Find(attribute);
  builder_->Report(found != nullptr ? found->value_at : element_.at, severity, std::move(what));
}

}  // namespace musher::tree
