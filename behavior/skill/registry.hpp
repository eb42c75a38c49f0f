#pragma once
// The skills of a program by name, and which of them a kind of robot has.
//
//   skill::Registry registry;
//   registry.Add<TakeOff>("take_off", drone);     // made for each run: TakeOff(drone)
//   registry.Add("beep", [] { return std::make_unique<skill::StepFunction>(…); });
//   skill::Manager manager(registry.All());
//
// A config file (toml/skills_toml.hpp): registry.Configure(config), and registry.Of(config,
// "cf2x") for its skills.
//
// Threads: one at a time.

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/behavior/skill/skill.hpp"

namespace musher::skill {

using Factory = std::function<std::unique_ptr<Skill>()>;

// A skill as one robot has it.
struct Entry {
  std::string name;
  Factory make;
  Settings settings{};
};

// Execution order of the skills of a composition; see compose.hpp.
enum class Order : std::uint8_t { kInOrder, kParallel, kFirstToFinish };

struct Part {
  std::string skill;
  Values parameters{};

  friend bool operator==(const Part&, const Part&) = default;
};

struct Config {
  struct Group {
    std::string name;
    std::vector<std::string> robots;  // kinds of robots; empty: all
    std::vector<std::string> skills;

    friend bool operator==(const Group&, const Group&) = default;
  };
  struct Composition {
    std::string name;
    Order order = Order::kInOrder;
    std::vector<Part> parts;

    friend bool operator==(const Composition&, const Composition&) = default;
  };
  std::vector<Group> groups;
  std::vector<std::pair<std::string, Settings>> settings;  // by skill
  std::vector<Composition> compositions{};                 // each after those that it runs

  friend bool operator==(const Config&, const Config&) = default;
};

class Registry {
 public:
  // Fails for a name that is empty, has a slash or is registered already, and with the errors of
  // the skill's table.
  Result<> Add(const std::string& name, Factory make);
  // Skills that are made from references to `parts`, which have to outlive them.
  template <class S, class... Parts>
  Result<> Add(const std::string& name, Parts&... parts) {
    return Add(name, Factory([&parts...] { return std::make_unique<S>(parts...); }));
  }

  const std::vector<Entry>& All() const { return entries_; }
  const Entry* Find(std::string_view name) const;
  std::vector<std::string> Names() const;

  // Takes over the settings of a config, and adds its compositions. Fails, with all errors, for an
  // unknown skill, for settings that do not fit one, and for what Compose() and Add() refuse; then
  // nothing has changed. Skills that were composed before keep the settings of their parts.
  Result<> Configure(const Config& config);

  // The skills of a kind of robot, in the order of the config. Fails for a kind and for a skill
  // that are not known, with the nearest.
  Result<std::vector<Entry>> Of(const Config& config, std::string_view robot) const;

 private:
  void Set(const std::string& skill, const Settings& settings, std::string& errors);

  std::vector<Entry> entries_;
};

}  // namespace musher::skill
