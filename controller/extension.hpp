#pragma once
// What another library adds to a controller: links to actuators of a protocol that the controller
// does not have itself, and services beside Musher's own. The controller knows no such library: a
// program passes the extensions that it wants (ControllerOptions::extensions).
//
// Threads: loop thread only.

#include <functional>
#include <memory>
#include <string>

#include "musher/base/result.hpp"
#include "musher/controller/link/actuator_link.hpp"
#include "musher/lifecycle/step/action.hpp"
#include "musher/transport/node.hpp"

namespace musher {

class ControllerShell;

// The open services of an extension.
class ExtensionServices {
 public:
  virtual ~ExtensionServices() = default;
  // Called for every record of the shell.
  virtual void OnRecord(const action::Record& record) = 0;
  // Whether an answer waits until its client can be reached: a machine that is stopped stays open
  // for it, for 3 s at most.
  virtual bool HoldsAnswers() const { return false; }
};

// What the services are made from. The node and the shell outlive them; `save_text` is to be
// copied.
struct ExtensionHost {
  transport::Node& node;
  ControllerShell& shell;
  // Saves a file of this name in the state folder; returns at once. May be empty.
  std::function<void(const std::string& name, const std::string& text)> save_text;
};

struct ControllerExtension {
  LinkMakers links;
  // Called each time the controller begins to lead the machine; the services are destroyed when it
  // no longer does. Null if the config does not enable them. May be empty.
  std::function<Result<std::unique_ptr<ExtensionServices>>(const ExtensionHost&)> open_services;
  bool serves_manager = false;  // whether it serves what `[policy] manager = true` enables
};

}  // namespace musher
