// docs/reference.md lists every command with each argument and option, and none that is not there.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <map>
#include <regex>
#include <set>
#include <sstream>

#include "musher/cli/command_line.hpp"
#include "musher/test/support/json_schema.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::cli::reference_test {

using ::testing::Contains;
using ::testing::IsEmpty;
using ::testing::Not;

// Of "## The `musher` program" in the reference: by its first words the rows of each command, and
// the text around the table.
struct Reference {
  std::map<std::string, std::string> commands;  // what is typed, of all its rows
  std::string rest;
};

const std::regex kLeadingWords("([a-z][a-z0-9-]*)( [a-z][a-z0-9-]*)?");

Reference ReadReference(const std::set<std::string>& commands) {
  std::ifstream file(SourceDir() + "/docs/reference.md");
  Reference reference;
  bool inside = false;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("## ")) inside = line == "## The `musher` program";
    if (line.starts_with("### ")) inside = false;
    if (!inside) continue;
    if (!line.starts_with("| `")) {
      reference.rest += line + "\n";
      continue;
    }
    const std::string typed = line.substr(3, line.find("` |") - 3);
    std::smatch words;
    if (!std::regex_search(typed, words, kLeadingWords)) continue;
    const std::string two = words.str();
    reference.commands[commands.contains(two) ? two : words[1].str()] += " " + typed + " ";
  }
  return reference;
}

std::set<std::string> Found(const std::string& text, const std::string& pattern) {
  const std::regex regex(pattern);
  std::set<std::string> found;
  for (std::sregex_iterator i(text.begin(), text.end(), regex), end; i != end; ++i) {
    found.insert(i->str());
  }
  return found;
}

// Command -> its arguments and options; "" has those of every command.
std::map<std::string, std::set<std::string>> ReadGrammar() {
  std::map<std::string, std::set<std::string>> grammar;
  for (const std::string& line : GrammarLines()) {
    const std::size_t last = line.rfind(' ');
    const std::string word = last == std::string::npos ? line : line.substr(last + 1);
    const bool is_option = word.starts_with("--");
    const bool is_argument = !Found(word, "^([A-Z]+|on.off)$").empty();
    const std::string command = last == std::string::npos ? "" : line.substr(0, last);
    if (is_option || is_argument) {
      grammar[command].insert(word);
    } else {
      grammar[line];
    }
  }
  return grammar;
}

TEST(Reference, ListsEveryCommandWithEachOfItsArgumentsAndOptions) {
  const auto grammar = ReadGrammar();
  ASSERT_GT(grammar.size(), 25U);
  std::set<std::string> commands;
  for (const auto& [command, words] : grammar) commands.insert(command);
  const Reference reference = ReadReference(commands);
  for (const auto& [command, words] : grammar) {
    if (command.empty()) continue;
    const auto row = reference.commands.find(command);
    ASSERT_NE(row, reference.commands.end()) << "there is no row of `" << command << "`";
    const auto options = Found(row->second, "--[a-z][a-z0-9-]*");
    for (const std::string& word : words) {
      if (word.starts_with("--")) {
        EXPECT_THAT(options, Contains(word)) << "of `" << command << "`";
      } else if (word == "on|off") {
        EXPECT_NE(row->second.find("on\\|off"), std::string::npos) << row->second;
      } else {
        EXPECT_THAT(Found(row->second, "[A-Z]+"), Contains(word)) << "of `" << command << "`";
      }
    }
    for (const std::string& option : options) {
      EXPECT_THAT(words, Contains(option)) << "`" << command << "` has no such option";
    }
  }
  const auto general = Found(reference.rest, "--[a-z][a-z0-9-]*");
  for (const std::string& option : grammar.at("")) EXPECT_THAT(general, Contains(option));
}

TEST(Reference, ListsNoCommandThatIsNotThere) {
  const auto grammar = ReadGrammar();
  std::set<std::string> commands;
  for (const auto& [command, words] : grammar) commands.insert(command);
  std::vector<std::string> unknown;
  for (const auto& [command, typed] : ReadReference(commands).commands) {
    if (command != "help" && !commands.contains(command)) unknown.push_back(command);
  }
  EXPECT_THAT(unknown, IsEmpty());
}

TEST(Grammar, HasOneWordForWhatGoesOnPrintingAndOneForTheNumberOfLines) {
  const auto grammar = ReadGrammar();
  for (const char* command : {"status", "behavior", "history", "logs"}) {
    EXPECT_THAT(grammar.at(command), Contains("--follow")) << command;
  }
  for (const char* command : {"history", "logs"}) {
    EXPECT_THAT(grammar.at(command), Contains("--lines")) << command;
  }
  for (const auto& [command, words] : grammar) {
    for (const char* other : {"--watch", "--tail", "--limit", "--count", "--number"}) {
      EXPECT_THAT(words, Not(Contains(other))) << "of `" << command << "`";
    }
  }
}

TEST(Schema, DescribesTheDocumentOfEachCommand) {
  const std::set<std::string> without = {"completion", "play", "record", "view"};
  const auto names = testing::SchemaNames();
  const auto grammar = ReadGrammar();
  for (const auto& [command, options] : grammar) {
    const bool family = std::any_of(grammar.begin(), grammar.end(), [&](const auto& other) {
      return other.first.starts_with(command + " ");
    });
    if (family || command.empty() || without.contains(command)) continue;
    EXPECT_THAT(names, Contains(command)) << "docs/cli.schema.json";
  }
}

// Calls `visit(key, schema, place)` for each key of each object of the schema.
void ForEachKey(const nlohmann::json& schema, const std::string& place,
                const std::function<void(const std::string&, const nlohmann::json&,
                                         const std::string&)>& visit) {
  if (!schema.is_structured()) return;
  if (schema.is_object() && schema.contains("properties")) {
    for (const auto& [key, of_key] : schema["properties"].items()) visit(key, of_key, place);
  }
  for (const auto& [name, part] : schema.items()) ForEachKey(part, place + "." + name, visit);
}

// Its types but null, of all its forms.
std::set<std::string> KindsOf(const nlohmann::json& schema) {
  if (schema.contains("enum")) return {"string"};
  if (schema.contains("$ref")) {
    const auto to = schema["$ref"].get<std::string>();
    return KindsOf(testing::Schema().at("$defs").at(to.substr(std::string("#/$defs/").size())));
  }
  std::set<std::string> kinds;
  if (schema.contains("anyOf")) {
    for (const nlohmann::json& form : schema["anyOf"]) kinds.merge(KindsOf(form));
  } else if (schema["type"].is_array()) {
    kinds = schema["type"].get<std::set<std::string>>();
  } else {
    kinds = {schema["type"].get<std::string>()};
  }
  kinds.erase("null");
  return kinds;
}

TEST(Schema, HasEveryKeyInEveryDocument) {
  const std::function<void(const nlohmann::json&, const std::string&)> check =
      [&](const nlohmann::json& schema, const std::string& place) {
        if (!schema.is_structured()) return;
        if (schema.is_object() && schema.contains("properties")) {
          std::set<std::string> keys;
          for (const auto& [key, of_key] : schema["properties"].items()) keys.insert(key);
          const auto required = schema.value("required", std::set<std::string>());
          EXPECT_EQ(required, keys) << place << ": what is not known is null, not left out";
        }
        for (const auto& [name, part] : schema.items()) check(part, place + "." + name);
      };
  check(testing::Schema().at("$defs"), "");
}

// One word for a thing, and one kind of value for a word. Words that count or list may do both.
TEST(Schema, HasOneKindOfValueForTheNameOfAThing) {
  const std::map<std::string, std::string> kinds = {
      {"actuator", "string"},   {"actuators", "object"},      {"argv", "array"},
      {"capability", "string"}, {"code", "integer"},          {"command", "string"},
      {"config", "string"},     {"emergency_stop", "object"}, {"epoch", "integer"},
      {"error", "string"},      {"goal_id", "string"},        {"health", "string"},
      {"host", "string"},       {"machine", "string"},        {"message", "string"},
      {"outcome", "string"},    {"phase", "string"},          {"pid", "integer"},
      {"reason", "string"},     {"skill", "string"},          {"stage", "integer"},
      {"state", "string"},      {"status", "string"},         {"switch", "integer"},
      {"target", "string"},     {"time", "string"},           {"topic", "string"}};
  std::set<std::string> found;
  ForEachKey(testing::Schema().at("$defs"), "",
             [&](const std::string& key, const nlohmann::json& schema, const std::string& place) {
               const auto kind = kinds.find(key);
               if (kind == kinds.end()) return;
               found.insert(key);
               EXPECT_EQ(KindsOf(schema), std::set<std::string>{kind->second})
                   << key << " in " << place;
             });
  EXPECT_EQ(found.size(), kinds.size()) << "a word of this list is in no document";
}

TEST(Schema, RefusesWhatItDoesNotDescribe) {
  const auto faults = [](const char* text) {
    return testing::SchemaFaults("check", nlohmann::json::parse(text));
  };
  EXPECT_THAT(faults(R"({"valid":true,"diagnostics":[]})"), IsEmpty());
  EXPECT_THAT(faults(R"({"valid":true})"), ::testing::ElementsAre(": no key diagnostics"));
  EXPECT_THAT(faults(R"({"valid":1,"diagnostics":[],"more":0})"), ::testing::SizeIs(2));
  EXPECT_THAT(faults(R"({"valid":true,"diagnostics":[{"file":null,"line":null,"column":null,)"
                     R"("severity":"loud","message":""}]})"),
              ::testing::ElementsAre(::testing::HasSubstr("diagnostics[0].severity")));
}

}  // namespace musher::cli::reference_test
