#pragma once
// The subcommands of `musher tree`; tree.cpp adds all of them.

namespace CLI {
class App;
}

namespace musher::cli {

class Grammar;

void AddTreeCheck(Grammar& grammar, CLI::App& family);
void AddTreeReplay(Grammar& grammar, CLI::App& family);

}  // namespace musher::cli
