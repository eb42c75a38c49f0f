#include "musher/cli/commands/commands.hpp"

#include "musher/cli/grammar/grammar.hpp"

namespace musher::cli {

void AddCommands(Grammar& grammar) {
#define MUSHER_CLI_GROUP(heading) grammar.Group(heading);
#define MUSHER_CLI_ADD(add) add(grammar);
  MUSHER_CLI_COMMANDS(MUSHER_CLI_GROUP, MUSHER_CLI_ADD)
#undef MUSHER_CLI_GROUP
#undef MUSHER_CLI_ADD
}

}  // namespace musher::cli
