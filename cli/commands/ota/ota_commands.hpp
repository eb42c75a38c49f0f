#pragma once
// The commands of the family `musher ota`, and the arguments that several of them have.

#include <string>

#include "musher/cli/grammar/grammar.hpp"

namespace musher::cli {

void AddOtaKeygen(Grammar& grammar, CLI::App& family);
void AddOtaBundle(Grammar& grammar, CLI::App& family);
void AddOtaInit(Grammar& grammar, CLI::App& family);
void AddOtaVerify(Grammar& grammar, CLI::App& family);
void AddOtaInstall(Grammar& grammar, CLI::App& family);
void AddOtaStatus(Grammar& grammar, CLI::App& family);
void AddOtaRollback(Grammar& grammar, CLI::App& family);

// --root: the upgrade root.
void AddRoot(Grammar& grammar, CLI::App& app, std::string& root);
// BUNDLE, required.
void AddBundle(Grammar& grammar, CLI::App& app, std::string& bundle);

}  // namespace musher::cli
