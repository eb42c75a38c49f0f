#pragma once
// Whether what `musher COMMAND --json` prints is what docs/cli.schema.json says: a small checker of
// JSON Schema, and stricter than one for users: a key that the schema does not have is a fault.

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace musher::testing {

// Fails the test for each document of `out` that does not fit its command. Nothing where `words`,
// those of the command line, have no --json.
void CheckDocuments(const std::vector<std::string>& words, const std::string& out);

// What is wrong with a document of that name in $defs, each with its place; empty: nothing.
std::vector<std::string> SchemaFaults(const std::string& name, const nlohmann::json& document);

// docs/cli.schema.json.
const nlohmann::json& Schema();
// The names in $defs.
std::vector<std::string> SchemaNames();

}  // namespace musher::testing
