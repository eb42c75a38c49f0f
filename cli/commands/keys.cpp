// musher keys init|add|revoke|list: the identities of a machine with [security]. Never prints
// secrets. Uses no network.

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <filesystem>

#include "musher/base/date_text.hpp"
#include "musher/cli/commands/commands.hpp"
#include "musher/cli/config/config_file.hpp"
#include "musher/cli/console/table.hpp"
#include "musher/cli/console/wall_time.hpp"
#include "musher/cli/grammar/grammar.hpp"
#include "musher/cli/render/json.hpp"
#include "musher/cyberdog/interfaces.hpp"
#include "musher/transport/dds/dds_node.hpp"
#include "musher/wire/dds_options.hpp"
#include "musher/wire/security/authority.hpp"

namespace musher::cli {
namespace {

struct KeysInitOptions {
  std::string where;  // a state config with [security], or a folder
  int days = 730;
  bool signed_only = false;
  bool force = false;
};

struct KeysAddOptions {
  std::string name;
  std::string role = "actuator";
  int days = 730;
  bool force = false;
};

struct KeysRevokeOptions {
  std::string name;
};

using transport::keys::Identity;
using transport::keys::IssueOptions;
using transport::keys::KeyFolder;
using transport::keys::Protection;
using transport::keys::Role;

constexpr const char* kOperator = "operator";

// The folder of --keys, or why there is none.
Result<KeyFolder> ChosenFolder(const GlobalOptions& global) {
  if (global.keys.empty()) {
    return Error{kCodeParametersInvalid,
                 "no folder of credentials given; use --keys FOLDER or $MUSHER_KEYS"};
  }
  return KeyFolder(std::filesystem::absolute(global.keys).lexically_normal());
}

// The folder and identities to create.
struct KeyPlan {
  KeyFolder folder{""};
  bool added = false;  // the config does not name the folder yet
  std::vector<std::pair<std::string, Role>> identities = {
      {transport::kControllerIdentity, Role::kController}, {kOperator, Role::kOperator}};
};

// For a config, or for a folder that may not exist yet. nullopt: the error is already printed.
std::optional<KeyPlan> PlanFor(const std::string& where, Console& console) {
  KeyPlan plan;
  if (std::filesystem::path(where).extension() != ".toml") {
    plan.folder = KeyFolder(std::filesystem::absolute(where).lexically_normal());
    return plan;
  }
  const auto config = LoadConfig(where, console);
  if (!config) return std::nullopt;
  // A new robot: the folder that `[security]` will name.
  plan.added = config->keys.empty();
  const auto beside = std::filesystem::absolute(where).lexically_normal().parent_path() / "keys";
  plan.folder = KeyFolder(plan.added ? beside.string() : config->keys);
  for (const ActuatorConfig& actuator : config->actuators) {
    for (const auto& [name, role] : plan.identities) {
      if (name != actuator.name) continue;
      console.Fail({kCodeParametersInvalid, "actuator '" + name +
                                                "': this name is reserved for an " +
                                                "identity of every machine; rename the actuator"});
      return std::nullopt;
    }
  }
  for (const ActuatorConfig& actuator : config->actuators) {
    plan.identities.emplace_back(actuator.name, Role::kActuator);
  }
  return plan;
}

std::string RoleText(const Identity& identity) {
  return identity.role ? std::string(RoleName(*identity.role)) : "?";
}

std::string NoteOf(const Identity& identity, std::int64_t now_ns) {
  if (identity.revoked) return "revoked";
  constexpr std::int64_t kSecond = 1'000'000'000;
  const std::int64_t left_s = identity.not_after.time_since_epoch().count() - now_ns / kSecond;
  if (left_s <= 0) return "expired";
  constexpr std::int64_t kDay = 86'400;
  if (left_s < 30 * kDay) return fmt::format("expires in {} days", left_s / kDay);
  return identity.has_key ? "" : "its private key is not in this folder";
}

// Prints what was done; with --json, the identities that now exist.
ExitCode Done(Console& console, const KeyFolder& folder, const std::string& text) {
  if (!console.mode().json) {
    console.Print(text);
    return ExitCode::kDone;
  }
  const auto identities = List(folder);
  if (!identities) return console.Fail(identities.error());
  console.Print(KeysJson(folder.path(), identities.value()));
  return ExitCode::kDone;
}

ExitCode KeysInit(const KeysInitOptions& options, const GlobalOptions& /*global*/,
                  Console& console) {
  const auto plan = PlanFor(options.where, console);
  if (!plan) return ExitCode::kUsage;
  const Protection protection = options.signed_only ? Protection::kSigned : Protection::kEncrypted;
  if (auto made = CreateAuthority(plan->folder, protection, options.force); !made) {
    return console.Fail(made.error());
  }
  for (const auto& [name, role] : plan->identities) {
    const IssueOptions issue{options.days, options.force};
    if (auto made = Issue(plan->folder, name, role, cyberdog::Interfaces(), issue); !made) {
      return console.Fail(made.error());
    }
  }
  const std::string& path = plan->folder.path();
  if (plan->added) {
    console.Note("now add to " + options.where + " the table [security] with keys = \"keys\"");
  }
  return Done(console, plan->folder,
              fmt::format("{0}: {1} identities\n"
                          "Move {2} off the robot: its owner can admit any process.\n"
                          "For the other commands: export MUSHER_KEYS={0}",
                          path, plan->identities.size(), plan->folder.CaFolder()));
}

ExitCode KeysAdd(const KeysAddOptions& options, const GlobalOptions& global, Console& console) {
  const auto folder = ChosenFolder(global);
  if (!folder) return console.Fail(folder.error());
  const Role role = transport::keys::RoleFrom(options.role).value();
  const IssueOptions issue{options.days, options.force};
  if (auto made = Issue(folder.value(), options.name, role, cyberdog::Interfaces(), issue); !made) {
    return console.Fail(made.error());
  }
  return Done(
      console, folder.value(),
      fmt::format("{0} is admitted as {1}. Give it a folder of its own with {0}.key, {0}.cert, "
                  "{0}.permissions,\n"
                  "identity_ca.cert, permissions_ca.cert, governance.p7s and revoked.crl of {2}.",
                  options.name, options.role, folder.value().path()));
}

ExitCode KeysRevoke(const KeysRevokeOptions& options, const GlobalOptions& global,
                    Console& console) {
  const auto folder = ChosenFolder(global);
  if (!folder) return console.Fail(folder.error());
  if (auto revoked = Revoke(folder.value(), options.name); !revoked) {
    return console.Fail(revoked.error());
  }
  return Done(
      console, folder.value(),
      fmt::format(
          "{0} is revoked in {1}. Processes read that file when they start: copy it into the "
          "folder\n"
          "of credentials on every host, then `musher down` and `musher up`. Until then {0} is "
          "still admitted.",
          options.name, folder.value().Revocations()));
}

ExitCode KeysList(const GlobalOptions& global, Console& console) {
  const auto folder = ChosenFolder(global);
  if (!folder) return console.Fail(folder.error());
  const auto identities = List(folder.value());
  if (!identities) return console.Fail(identities.error());
  const std::int64_t now = WallNow();
  Table table({"NAME", "ROLE", "VALID UNTIL", "NOTE"});
  for (const Identity& identity : identities.value()) {
    table.Add({{identity.name},
               {RoleText(identity)},
               {FormatUtc(identity.not_after)},
               {NoteOf(identity, now), identity.revoked ? Style::kBad : Style::kPlain}});
  }
  return Done(console, folder.value(), table.Text(console.mode().colour));
}

void AddDays(CLI::App& app, int& days) {
  app.add_option("--days", days, "Days that a certificate is valid; default 730")
      ->check(CLI::Range(1, 3650).description(""))
      ->type_name("N");
}

void AddKeysInit(Grammar& grammar, CLI::App& family) {
  auto [app, options] =
      grammar.Add("init", "Create a machine's CAs and first identities", KeysInit, &family);
  grammar
      .Offer(app.add_option("WHERE", options.where,
                            "A state config with [security]: for the controller,\n"
                            "the operator and all its actuators; or a folder"),
             Names::kConfigs)
      ->required()
      ->type_name("");
  AddDays(app, options.days);
  app.add_flag("--signed-only", options.signed_only,
               "Sign data but do not encrypt it; default: both");
  app.add_flag("--force", options.force, "Replace existing ones");
}

void AddKeysAdd(Grammar& grammar, CLI::App& family) {
  auto [app, options] = grammar.Add("add", "Create one more identity", KeysAdd, &family);
  grammar
      .Offer(app.add_option("NAME", options.name, "Name of an actuator or a person"),
             Names::kActuators)
      ->required()
      ->type_name("");
  grammar.OneOf(app.add_option("--role", options.role, "Its permissions; default actuator"),
                {"controller", "actuator", "operator", "observer"});
  AddDays(app, options.days);
  app.add_flag("--force", options.force, "Replace it and revoke the previous one");
}

void AddKeysRevoke(Grammar& grammar, CLI::App& family) {
  auto [app, options] =
      grammar.Add("revoke", "Revoke an identity's certificate", KeysRevoke, &family);
  app.add_option("NAME", options.name, "Name of the identity")->required()->type_name("");
}

}  // namespace

void AddKeys(Grammar& grammar) {
  CLI::App& family = grammar.AddFamily("keys", "Create and revoke the credentials of processes",
                                       "musher keys init robot.toml");
  AddKeysInit(grammar, family);
  AddKeysAdd(grammar, family);
  AddKeysRevoke(grammar, family);
  grammar.Add("list", "Show identities, their roles and expiry dates", KeysList, &family);
}

}  // namespace musher::cli
